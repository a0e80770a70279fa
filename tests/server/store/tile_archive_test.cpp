#include "server/store/tile_archive.h"

#include <gtest/gtest.h>
#include <minizip/unzip.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "tests/support/temporary_folder.h"

namespace lodestream::store {
namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

template <class Number>
Number number_at(const std::string& bytes, std::size_t place) {
    Number number{};
    std::memcpy(&number, bytes.data() + place, sizeof number);
    return number;
}

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

class TileArchiveTest : public ::testing::Test {
  protected:
    // Writes all of them; what is read back by the ZIP library is in `entries`, in the file's order in `order`.
    void write(const std::map<std::string, std::string>& files) {
        auto archive = TileArchive::create(file);
        ASSERT_TRUE(archive) << archive.error().message;
        for (const auto& [path, content] : files) ASSERT_TRUE(archive->add(path, bytes_of(content)));
        ASSERT_TRUE(archive->finish());
        unzFile zip = unzOpen64(file.c_str());
        ASSERT_NE(zip, nullptr);
        for (int found = unzGoToFirstFile(zip); found == UNZ_OK; found = unzGoToNextFile(zip)) {
            std::string name(256, '\0');
            unz_file_info64 info{};
            unzGetCurrentFileInfo64(zip, &info, name.data(), name.size(), nullptr, 0, nullptr, 0);
            name.resize(info.size_filename);
            EXPECT_EQ(info.compression_method, 0u);
            std::string content(info.uncompressed_size, '\0');
            ASSERT_EQ(unzOpenCurrentFile(zip), UNZ_OK);
            EXPECT_EQ(unzReadCurrentFile(zip, content.data(), static_cast<unsigned>(content.size())),
                      static_cast<int>(content.size()));
            EXPECT_EQ(unzCloseCurrentFile(zip), UNZ_OK) << "the sum is right";
            entries[name] = content;
            order.push_back(name);
        }
        unzClose(zip);
    }

    testing::TemporaryFolder folder;
    std::filesystem::path file = folder.path() / "deep" / "tiles.3tz";
    std::map<std::string, std::string> entries;
    std::vector<std::string> order;
};

TEST_F(TileArchiveTest, TheIndexIsLastAndLeadsToEveryEntry) {
    const std::map<std::string, std::string> files{
        {"tileset.json", "{}"}, {"tile-0.glb", std::string(70'000, 'a')}, {"tile-1.glb", ""}, {"sub/tile-2.glb", "b"}};
    write(files);
    ASSERT_EQ(order.size(), files.size() + 1);
    EXPECT_EQ(order.back(), archive_index_name);
    for (const auto& [path, content] : files) EXPECT_EQ(entries[path], content);

    const std::string all = text_of(file), index = entries[archive_index_name];
    ASSERT_EQ(index.size(), 24 * files.size());
    std::map<std::string, std::string> found;
    std::array<std::uint64_t, 2> before{};
    for (std::size_t i = 0; i < index.size(); i += 24) {
        const auto hash = number_at<std::array<std::uint64_t, 2>>(index, i);
        EXPECT_LT(before, hash) << "sorted by the hash's two numbers";
        before = hash;
        const auto header = number_at<std::uint64_t>(index, i + 16);
        ASSERT_EQ(all.substr(header, 4), "PK\3\4");
        EXPECT_EQ(number_at<std::uint16_t>(all, header + 6) & 8, 0) << "sizes stand in the header itself";
        const auto size = number_at<std::uint32_t>(all, header + 18);
        EXPECT_EQ(number_at<std::uint32_t>(all, header + 22), size);
        const auto name_size = number_at<std::uint16_t>(all, header + 26);
        ASSERT_EQ(number_at<std::uint16_t>(all, header + 28), 0) << "nothing between the path and the content";
        found[all.substr(header + 30, name_size)] = all.substr(header + 30 + name_size, size);
    }
    EXPECT_EQ(found, files);
}

// The MD5 of "tileset.json" begins with these bytes, as any tool says.
TEST_F(TileArchiveTest, HashesThePathAlone) {
    write({{"tileset.json", "whatever"}});
    EXPECT_EQ(entries[archive_index_name].substr(0, 4), std::string("\xc0\x9b\xde\xa7", 4));
}

TEST_F(TileArchiveTest, EqualTilesMakeEqualFiles) {
    write({{"tileset.json", "{}"}, {"a", "1"}});
    const std::string once = text_of(file);
    write({{"tileset.json", "{}"}, {"a", "1"}});
    EXPECT_EQ(text_of(file), once);
}

TEST_F(TileArchiveTest, OneThatWasNotFinishedLeavesWhatWasThere) {
    write({{"tileset.json", "{}"}});
    const std::string before = text_of(file);
    {
        auto archive = TileArchive::create(file);
        ASSERT_TRUE(archive);
        ASSERT_TRUE(archive->add("tileset.json", bytes_of("another")));
    }
    EXPECT_EQ(text_of(file), before);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.parent_path()), {}), 1);
}

TEST_F(TileArchiveTest, SaysWhereItCannotBeWritten) {
    std::ofstream(folder.path() / "file") << "not a folder";
    const auto archive = TileArchive::create(folder.path() / "file" / "tiles.3tz");
    ASSERT_FALSE(archive.ok());
    EXPECT_EQ(archive.error().code, ErrorCode::io);
    EXPECT_NE(archive.error().message.find("tiles.3tz"), std::string::npos);
}

}  // namespace
}  // namespace lodestream::store
