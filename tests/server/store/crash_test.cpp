// The promise of store.h: a crash at any instant leaves either nothing or the whole.
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <set>
#include <thread>

#include "server/store/store.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::store {
namespace {

namespace fs = std::filesystem;

constexpr int crash_count = 50;
constexpr int asset_count = 5;
constexpr int key_count = 3;
constexpr int longest_life_ms = 40;

std::string asset_id(int i) {
    return "asset-" + std::to_string(i);
}
std::string key_name(int i) {
    return i == 0 ? "bake" : "level/" + std::to_string(i);
}

std::string sha256_of(const std::vector<std::byte>& bytes) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned length = 0;
    EVP_Digest(bytes.data(), bytes.size(), digest, &length, EVP_sha256(), nullptr);
    std::string hex;
    for (unsigned i = 0; i < length; ++i) {
        char pair[3];
        std::snprintf(pair, sizeof pair, "%02x", digest[i]);
        hex += pair;
    }
    return hex;
}

// Puts, replaces and removes for ever; tells through `started` when the store is open.
[[noreturn]] void write_for_ever(const fs::path& folder, unsigned seed, int started) {
    auto store = Store::open(folder);
    if (!store) ::_exit(1);
    if (::write(started, "x", 1) != 1) ::_exit(1);
    std::mt19937 random(seed);
    for (;;) {
        proto::Asset asset;
        asset.id = asset.name = asset_id(static_cast<int>(random() % asset_count));
        asset.kind = "mesh";
        if (random() % 8 == 0) static_cast<void>(store->remove_asset(asset.id));
        if (!store->put_asset(asset)) ::_exit(1);
        std::vector<std::byte> bytes(random() % 200'000);
        for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
        for (int key = 0; key < key_count; ++key) {
            bytes.push_back(std::byte{0});
            if (!store->put_content(asset.id, key_name(key), "bin", bytes)) ::_exit(1);
        }
        asset.status = proto::AssetStatus::ready;
        if (!store->put_asset(asset)) ::_exit(1);
    }
}

void expect_consistent(const fs::path& folder) {
    auto store = Store::open(folder);
    ASSERT_TRUE(store) << store.error().message;
    std::set<fs::path> named;
    for (int asset = 0; asset < asset_count; ++asset)
        for (int key = 0; key < key_count; ++key) {
            const auto content = store->content(asset_id(asset), key_name(key));
            if (!content) continue;
            const auto bytes = read_file(content->file.path, 1u << 20);
            ASSERT_TRUE(bytes) << bytes.error().message;
            EXPECT_EQ(bytes->size(), content->file.bytes);
            EXPECT_EQ(sha256_of(*bytes), content->file.hash);
            named.insert(content->file.path);
        }
    std::set<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "content"))
        if (entry.is_regular_file()) found.insert(entry.path());
    EXPECT_EQ(found, named);
    EXPECT_TRUE(fs::is_empty(folder / "incoming"));
    const auto assets = store->assets();
    ASSERT_TRUE(assets);
    for (const proto::Asset& asset : *assets) {
        EXPECT_NE(asset.status, proto::AssetStatus::baking);
        if (asset.status == proto::AssetStatus::ready) {
            EXPECT_TRUE(store->content(asset.id, "bake"));
        }
    }
}

TEST(StoreCrash, LeavesNothingOrTheWhole) {
    testing::TemporaryFolder temporary;
    const fs::path folder = temporary.path() / "store";
    std::mt19937 random(20'240'613);
    int killed = 0;
    for (int crash = 0; crash < crash_count; ++crash) {
        int started[2];
        ASSERT_EQ(::pipe(started), 0);
        const pid_t child = ::fork();
        if (child == 0) write_for_ever(folder, static_cast<unsigned>(crash), started[1]);
        ::close(started[1]);
        char byte = 0;
        ASSERT_EQ(::read(started[0], &byte, 1), 1);
        ::close(started[0]);
        std::this_thread::sleep_for(std::chrono::microseconds(random() % (longest_life_ms * 1000)));
        ::kill(child, SIGKILL);
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        killed += WIFSIGNALED(status);
        expect_consistent(folder);
        if (::testing::Test::HasFailure()) FAIL() << "after crash " << crash;
    }
    EXPECT_EQ(killed, crash_count);  // none failed by itself
}

}  // namespace
}  // namespace lodestream::store
