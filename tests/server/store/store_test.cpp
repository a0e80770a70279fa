#include "server/store/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <fstream>
#include <latch>
#include <thread>

#include "server/store/sqlite.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::store {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<std::byte> bytes_of(std::string_view text) {
    const auto* data = reinterpret_cast<const std::byte*>(text.data());
    return {data, data + text.size()};
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

proto::Asset asset_named(const std::string& id, const std::string& name,
                         proto::AssetStatus status = proto::AssetStatus::ready) {
    proto::Asset asset;
    asset.id = id;
    asset.name = name;
    asset.kind = "mesh";
    asset.triangles = 12;
    asset.vertices = 8;
    asset.status = status;
    return asset;
}

std::size_t files_below(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) count += entry.is_regular_file();
    return count;
}

constexpr const char* sha256_of_abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

class StoreTest : public ::testing::Test {
  protected:
    Store open() {
        auto store = Store::open(folder());
        if (!store) throw std::runtime_error(store.error().message);
        return std::move(*store);
    }
    fs::path folder() const { return temporary_.path() / "store"; }
    fs::path content() const { return folder() / "content"; }

  private:
    testing::TemporaryFolder temporary_;
};

TEST_F(StoreTest, KeepsAssetsAcrossAReopen) {
    proto::Asset asset = asset_named("teapot", "Tea pot");
    asset.bounds_min = {{-1.0, -0.1, 0.3}};
    asset.levels.resize(2);
    asset.levels[1].max_error = 0.1 + 0.2;
    {
        Store store = open();
        ASSERT_TRUE(store.put_asset(asset));
    }
    Store store = open();
    for (const char* key : {"teapot", "Tea pot"}) {
        const auto read = store.asset(key);
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(read->name, "Tea pot");
        EXPECT_EQ(read->bounds_min, asset.bounds_min);
        EXPECT_EQ(read->levels.at(1).max_error, 0.1 + 0.2);
    }
}

TEST_F(StoreTest, FindsAnIdBeforeAName) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "b")));
    ASSERT_TRUE(store.put_asset(asset_named("b", "c")));
    EXPECT_EQ(store.asset("b")->id, "b");
    EXPECT_EQ(store.asset("c")->id, "b");
}

TEST_F(StoreTest, ListsAssetsByName) {
    Store store = open();
    for (const char* name : {"zebra", "ant", "mole"})
        ASSERT_TRUE(store.put_asset(asset_named(std::string("id-") + name, name)));
    const auto assets = store.assets();
    ASSERT_EQ(assets->size(), 3u);
    EXPECT_EQ(assets->at(0).name, "ant");
    EXPECT_EQ(assets->at(2).name, "zebra");
}

TEST_F(StoreTest, RefusesANameThatAnotherIdHas) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "same")));
    const auto status = store.put_asset(asset_named("b", "same"));
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::conflict);
    EXPECT_THAT(status.error().message, HasSubstr("same"));
    EXPECT_TRUE(store.put_asset(asset_named("a", "other")));
    EXPECT_TRUE(store.put_asset(asset_named("b", "same")));
}

TEST_F(StoreTest, ReplacingAnAssetKeepsItsContent) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a", proto::AssetStatus::baking)));
    ASSERT_TRUE(store.put_content("a", "bake", "bin", bytes_of("abc")));
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    EXPECT_TRUE(store.content("a", "bake"));
}

TEST_F(StoreTest, NamesContentByItsHash) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    const auto file = store.put_content("a", "level/3", "glb", bytes_of("abc"), "{\"record\":1}");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->hash, sha256_of_abc);
    EXPECT_EQ(file->path, content() / "ba" / (std::string(sha256_of_abc) + ".glb"));
    EXPECT_EQ(text_of(file->path), "abc");
    const auto read = store.content("a", "level/3");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->file.hash, sha256_of_abc);
    EXPECT_EQ(read->file.bytes, 3u);
    EXPECT_EQ(read->record, "{\"record\":1}");
    EXPECT_EQ(store.file(sha256_of_abc, "glb")->bytes, 3u);
    EXPECT_EQ(files_below(folder() / "incoming"), 0u);
}

TEST_F(StoreTest, KeepsEmptyContentAndBinaryRecords) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    const std::string record("with\0nul", 8);
    ASSERT_TRUE(store.put_content("a", "k", "bin", {}, record));
    EXPECT_EQ(store.content("a", "k")->file.bytes, 0u);
    EXPECT_EQ(store.content("a", "k")->record, record);
}

TEST_F(StoreTest, ReplacingAKeyDropsTheOldFile) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    const auto old = store.put_content("a", "k", "bin", bytes_of("old"));
    ASSERT_TRUE(store.put_content("a", "k", "bin", bytes_of("new")));
    EXPECT_FALSE(fs::exists(old->path));
    EXPECT_EQ(files_below(content()), 1u);
    ASSERT_TRUE(store.put_content("a", "k", "bin", bytes_of("new"), "same bytes again"));
    EXPECT_EQ(text_of(store.content("a", "k")->file.path), "new");
}

TEST_F(StoreTest, SharedBytesGoWithTheirLastOwner) {
    Store store = open();
    for (const char* id : {"a", "b"}) {
        ASSERT_TRUE(store.put_asset(asset_named(id, id)));
        ASSERT_TRUE(store.put_content(id, "k", "bin", bytes_of("abc")));
    }
    ASSERT_TRUE(store.remove_asset("a"));
    EXPECT_TRUE(store.file(sha256_of_abc, "bin"));
    EXPECT_FALSE(store.content("a", "k"));
    ASSERT_TRUE(store.remove_asset("b"));
    EXPECT_FALSE(store.file(sha256_of_abc, "bin"));
    EXPECT_EQ(files_below(content()), 0u);
}

TEST_F(StoreTest, SaysWhatIsNotThere) {
    Store store = open();
    EXPECT_EQ(store.asset("nobody").error().code, ErrorCode::not_found);
    EXPECT_EQ(store.remove_asset("nobody").error().code, ErrorCode::not_found);
    EXPECT_EQ(store.content("nobody", "k").error().code, ErrorCode::not_found);
    EXPECT_EQ(store.put_content("nobody", "k", "bin", bytes_of("abc")).error().code, ErrorCode::not_found);
    EXPECT_EQ(files_below(content()) + files_below(folder() / "incoming"), 0u);
}

TEST_F(StoreTest, HostileNamesLeadNowhere) {
    Store store = open();
    const std::string id = "../../etc/passwd'; DROP TABLE asset; --";
    ASSERT_TRUE(store.put_asset(asset_named(id, id)));
    ASSERT_TRUE(store.put_content(id, "../../../escape", "bin", bytes_of("abc")));
    EXPECT_EQ(store.asset(id)->id, id);
    EXPECT_EQ(files_below(folder().parent_path()), files_below(folder()));
    for (const char* extension : {"", ".", "..", "../x", "a/b", "GLB", "toolongext", "a b"})
        EXPECT_EQ(store.put_content(id, "k", extension, bytes_of("x")).error().code, ErrorCode::invalid_input)
            << extension;
    for (const std::string& key :
         {std::string(), std::string("a\nb"), std::string("a\0b", 3), std::string(2000, 'x')}) {
        EXPECT_FALSE(store.put_content(id, key, "bin", bytes_of("x")));
        EXPECT_FALSE(store.put_asset(asset_named(key, "name")));
        EXPECT_FALSE(store.put_asset(asset_named("id", key)));
    }
    const std::string hash = sha256_of_abc;
    for (const std::string& bad : {std::string("../../../../etc/passwd"), hash.substr(1), hash + "0",
                                   "BA" + hash.substr(2), std::string(64, '.')})
        EXPECT_EQ(store.file(bad, "bin").error().code, ErrorCode::not_found) << bad;
    EXPECT_FALSE(store.file(hash, "glb"));
    EXPECT_FALSE(store.file(hash, "../bin"));
}

TEST_F(StoreTest, DoesNotFollowSymbolicLinks) {
    Store store = open();
    fs::create_directories(content() / "ba");
    fs::create_symlink("/etc/passwd", content() / "ba" / (std::string(sha256_of_abc) + ".glb"));
    EXPECT_FALSE(store.file(sha256_of_abc, "glb"));
}

TEST_F(StoreTest, SweepsIncomingAndUnnamedFiles) {
    {
        Store store = open();
        ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
        ASSERT_TRUE(store.put_content("a", "k", "bin", bytes_of("abc")));
    }
    std::ofstream(folder() / "incoming" / "half-written") << "x";
    std::ofstream(content() / "ba" / (std::string(64, 'b') + ".bin")) << "x";
    std::ofstream(content() / "stray") << "x";
    fs::create_directories(content() / "zz");
    fs::copy_file(content() / "ba" / (std::string(sha256_of_abc) + ".bin"),
                  content() / "zz" / (std::string(sha256_of_abc) + ".bin"));
    Store store = open();
    EXPECT_EQ(files_below(folder() / "incoming"), 0u);
    EXPECT_EQ(files_below(content()), 1u);
    EXPECT_TRUE(store.content("a", "k"));
}

TEST_F(StoreTest, DropsRowsWhoseFileIsGoneOrOfAnotherSize) {
    {
        Store store = open();
        for (const char* id : {"gone", "short", "level"}) {
            ASSERT_TRUE(store.put_asset(asset_named(id, id)));
            ASSERT_TRUE(store.put_content(id, "bake", "bin", bytes_of(std::string("bake of ") + id)));
            ASSERT_TRUE(store.put_content(id, "level/0", "glb", bytes_of(std::string("level of ") + id)));
        }
        fs::remove(store.content("gone", "bake")->file.path);
        fs::resize_file(store.content("short", "bake")->file.path, 2);
        fs::remove(store.content("level", "level/0")->file.path);
    }
    Store store = open();
    for (const char* id : {"gone", "short"}) {
        EXPECT_FALSE(store.content(id, "bake")) << id;
        EXPECT_TRUE(store.content(id, "level/0")) << id;
        EXPECT_EQ(store.asset(id)->status, proto::AssetStatus::failed) << id;
        EXPECT_THAT(store.asset(id)->error, HasSubstr("missing"));
    }
    EXPECT_FALSE(store.content("level", "level/0"));
    EXPECT_EQ(store.asset("level")->status, proto::AssetStatus::ready);
}

TEST_F(StoreTest, BakesThatACrashCutShortBecomeFailed) {
    {
        Store store = open();
        ASSERT_TRUE(store.put_asset(asset_named("a", "a", proto::AssetStatus::baking)));
    }
    Store store = open();
    EXPECT_EQ(store.asset("a")->status, proto::AssetStatus::failed);
    EXPECT_THAT(store.asset("a")->error, HasSubstr("stopped during the bake"));
    EXPECT_TRUE(store.put_asset(asset_named("a", "a", proto::AssetStatus::baking)));
}

TEST_F(StoreTest, ASecondProcessNeitherSweepsNorDisturbs) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a", proto::AssetStatus::baking)));
    std::ofstream(folder() / "incoming" / "being-written") << "x";
    const pid_t child = ::fork();
    if (child == 0) {
        auto second = Store::open(folder());
        const bool done =
            second && second->put_asset(asset_named("b", "b")) && second->put_content("b", "k", "bin", bytes_of("abc"));
        ::_exit(done ? 0 : 1);
    }
    int status = 1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(store.asset("a")->status, proto::AssetStatus::baking);
    EXPECT_TRUE(fs::exists(folder() / "incoming" / "being-written"));
    EXPECT_TRUE(store.content("b", "k"));
}

TEST_F(StoreTest, NodesAreAllWrittenOrNoneAndGoWithTheirAsset) {
    {
        Store store = open();
        ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
        EXPECT_FALSE(*store.has_nodes("a"));
        EXPECT_EQ(store.put_nodes("b", std::vector<Store::Node>{{1, "x"}}).error().code, ErrorCode::not_found);
        ASSERT_TRUE(store.put_nodes("a", std::vector<Store::Node>{{7, "seven"}, {2, "two"}}));
        ASSERT_TRUE(store.put_nodes("a", std::vector<Store::Node>{{7, "7"}}));
    }
    Store store = open();
    const auto nodes = store.nodes("a");
    ASSERT_TRUE(nodes);
    ASSERT_EQ(nodes->size(), 2u);
    EXPECT_EQ((*nodes)[0].state, "two");
    EXPECT_EQ((*nodes)[1].node, 7u);
    EXPECT_EQ((*nodes)[1].state, "7");
    EXPECT_TRUE(*store.has_nodes("a"));
    ASSERT_TRUE(store.remove_asset("a"));
    EXPECT_FALSE(*store.has_nodes("a"));
}

TEST_F(StoreTest, TransientBytesAreServedAndSweptAtTheNextStart) {
    std::string hash;
    {
        Store store = open();
        const auto file = store.put_transient("glb", bytes_of("abc"));
        ASSERT_TRUE(file);
        hash = file->hash;
        ASSERT_TRUE(store.put_transient("glb", bytes_of("abc")));
        EXPECT_EQ(store.file(hash, "glb")->bytes, 3u);
        EXPECT_TRUE(fs::is_empty(folder() / "incoming"));
    }
    EXPECT_FALSE(open().file(hash, "glb"));
}

TEST_F(StoreTest, AStoreOfTheFirstVersionGetsWhatIsNew) {
    { Store store = open(); }
    {
        auto database = Database::open(folder() / "catalogue.sqlite");
        ASSERT_TRUE(database);
        ASSERT_TRUE(database->execute("DROP TABLE node; PRAGMA user_version = 1;"));
    }
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    EXPECT_TRUE(store.put_nodes("a", std::vector<Store::Node>{{1, "x"}}));
}

TEST_F(StoreTest, RefusesAStoreOfANewerVersion) {
    { Store store = open(); }
    std::fstream file(folder() / "catalogue.sqlite", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(60);  // user_version in SQLite's header, big endian
    file.write("\0\0\0\x63", 4);
    file.close();
    const auto store = Store::open(folder());
    ASSERT_FALSE(store);
    EXPECT_EQ(store.error().code, ErrorCode::conflict);
    EXPECT_THAT(store.error().message, HasSubstr("newer version"));
}

TEST_F(StoreTest, AnInterruptedBakeWithItsModelCanBeGoneOnWith) {
    {
        Store store = open();
        ASSERT_TRUE(store.put_asset(asset_named("a", "a", proto::AssetStatus::baking)));
        ASSERT_TRUE(store.put_content("a", imported_key, "model", bytes_of("mesh"), "1"));
        ASSERT_TRUE(store.put_asset(asset_named("b", "b", proto::AssetStatus::baking)));
        EXPECT_TRUE(store.interrupted().empty());
    }
    Store store = open();
    EXPECT_EQ(store.interrupted(), std::vector<std::string>{"a"});
    EXPECT_EQ(store.asset("a")->status, proto::AssetStatus::baking);
    EXPECT_EQ(store.asset("b")->status, proto::AssetStatus::failed);
    EXPECT_TRUE(open().interrupted().empty());  // the first one may be at it
}

TEST_F(StoreTest, ARecordChangesAlone) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("a", "a")));
    ASSERT_TRUE(store.put_content("a", "k", "bin", bytes_of("abc"), "old"));
    EXPECT_TRUE(store.set_record("a", "k", "new"));
    EXPECT_EQ(store.content("a", "k")->record, "new");
    EXPECT_EQ(store.content("a", "k")->file.hash, sha256_of_abc);
    EXPECT_EQ(store.set_record("a", "other", "x").error().code, ErrorCode::not_found);
    EXPECT_EQ(store.set_record("b", "k", "x").error().code, ErrorCode::not_found);
}

TEST_F(StoreTest, RemovedContentTakesItsFileUnlessItIsNamedElsewhere) {
    Store store = open();
    for (const char* id : {"a", "b"}) {
        ASSERT_TRUE(store.put_asset(asset_named(id, id)));
        ASSERT_TRUE(store.put_content(id, "k", "bin", bytes_of("abc")));
    }
    EXPECT_TRUE(store.remove_content("a", "k"));
    EXPECT_FALSE(store.content("a", "k"));
    EXPECT_EQ(files_below(content()), 1u);
    EXPECT_TRUE(store.remove_content("b", "k"));
    EXPECT_EQ(files_below(content()), 0u);
    EXPECT_TRUE(store.remove_content("b", "k"));
}

TEST_F(StoreTest, RefusesWhatIsNotAStore) {
    fs::create_directories(folder());
    std::ofstream(folder() / "catalogue.sqlite") << std::string(5000, 'x');
    const auto garbage = Store::open(folder());
    ASSERT_FALSE(garbage);
    EXPECT_EQ(garbage.error().code, ErrorCode::io);
    std::ofstream(folder().parent_path() / "file") << "x";
    const auto file = Store::open(folder().parent_path() / "file");
    ASSERT_FALSE(file);
    EXPECT_THAT(file.error().message, HasSubstr("file"));
}

TEST_F(StoreTest, CheckFailsWhereTheDiskTakesNoWrites) {
    Store store = open();
    EXPECT_TRUE(store.check());
    fs::remove(folder() / "incoming");
    EXPECT_FALSE(store.check());
}

TEST_F(StoreTest, ManyThreadsReadAndWriteAtOnce) {
    Store store = open();
    ASSERT_TRUE(store.put_asset(asset_named("shared", "shared")));
    constexpr int thread_count = 4, rounds = 12;
    std::latch start(thread_count);
    std::vector<std::thread> threads;
    for (int t = 0; t < thread_count; ++t)
        threads.emplace_back([&, t] {
            start.arrive_and_wait();
            const std::string own = "own-" + std::to_string(t);
            for (int i = 0; i < rounds; ++i) {
                EXPECT_TRUE(store.put_asset(asset_named(own, own)));
                EXPECT_TRUE(store.put_content(own, "k", "bin", bytes_of(std::to_string(i % 3))));
                EXPECT_TRUE(
                    store.put_content("shared", "k" + std::to_string(i % 2), "bin", bytes_of(std::to_string(t % 2))));
                EXPECT_TRUE(store.assets());
                EXPECT_TRUE(store.content("shared", "k" + std::to_string(i % 2)));
                EXPECT_TRUE(store.remove_asset(own));
            }
        });
    for (std::thread& thread : threads) thread.join();
    for (const char* key : {"k0", "k1"}) EXPECT_TRUE(fs::exists(store.content("shared", key)->file.path));
    EXPECT_LE(files_below(content()), 2u);
}

TEST(ReadFile, RefusesFoldersMissingFilesAndTooMuch) {
    testing::TemporaryFolder folder;
    std::ofstream(folder.path() / "f") << "hello";
    EXPECT_EQ(read_file(folder.path() / "f", 5)->size(), 5u);
    EXPECT_EQ(read_file(folder.path() / "f", 4).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(read_file(folder.path() / "g", 4).error().code, ErrorCode::not_found);
    EXPECT_EQ(read_file(folder.path(), 4096).error().code, ErrorCode::invalid_input);
}

}  // namespace
}  // namespace lodestream::store
