#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "server/importer/formats.h"
#include "tests/server/importer/inputs.h"
#include "tests/server/importer/sane.h"

namespace lodestream::importer {
namespace {

using ::testing::HasSubstr;
using testing::import_text;

std::string big_endian(std::uint32_t value, int bytes) {
    std::string out;
    for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(value >> (8 * i));
    return out;
}

// PNG with its data in one stored deflate block; checksums are left zero, which decoders of hostile data ignore or not.
std::string png(std::uint32_t width, std::uint32_t height, int depth, int color_type, const std::string& rows) {
    const auto chunk = [](const std::string& name, const std::string& data) {
        return big_endian(static_cast<std::uint32_t>(data.size()), 4) + name + data + big_endian(0, 4);
    };
    const auto n = static_cast<int>(rows.size());
    std::string stored = "\x78\x01\x01";
    for (const int length : {n, 0xffff ^ n})
        stored += {static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
    const std::string header = big_endian(width, 4) + big_endian(height, 4) +
                               std::string{static_cast<char>(depth), static_cast<char>(color_type), 0, 0, 0};
    return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", stored + rows + big_endian(0, 4)) +
           chunk("IEND", "");
}

std::string grey16_rows(std::uint32_t width, const std::vector<std::uint32_t>& levels) {
    std::string rows;
    for (std::size_t i = 0; i < levels.size(); ++i) {
        if (i % width == 0) rows += '\0';  // no filter
        rows += big_endian(levels[i], 2);
    }
    return rows;
}

TEST(ImportTerrain, Png16GivesOneMetreCells) {
    const auto model = import_text(png(3, 2, 16, 0, grey16_rows(3, {0, 1000, 65535, 0, 0, 0})), Format::terrain_png);
    ASSERT_TRUE(model.ok()) << model.error().message;
    testing::expect_sane(*model, "png");
    EXPECT_EQ(model->kind, mesh::Kind::terrain);
    EXPECT_EQ(model->mesh.triangles.size(), 4u);
    EXPECT_TRUE(testing::mentions(model.warnings, "1 cm a grey level"));
    float highest = 0;
    for (const Vec3f& p : model->mesh.positions) highest = std::max(highest, p.y);
    EXPECT_FLOAT_EQ(highest, static_cast<float>(65535 * png_metres_per_level));
    for (const Vec3f& n : model->mesh.normals) EXPECT_GT(n.y, 0);
}

TEST(ImportTerrain, RefusesPngsThatHoldNoHeights) {
    EXPECT_EQ(import_text(png(2, 2, 8, 2, std::string(14, '\0')), Format::terrain_png).error().code,
              ErrorCode::unsupported);
    EXPECT_EQ(import_text(png(2, 2, 16, 0, "short"), Format::terrain_png).error().code, ErrorCode::invalid_input);
    EXPECT_EQ(import_text(png(20000, 20000, 16, 0, ""), Format::terrain_png).error().code, ErrorCode::limit_exceeded);
    EXPECT_FALSE(import_text(png(1, 4, 16, 0, grey16_rows(1, {1, 2, 3, 4})), Format::terrain_png).ok());
}

TEST(ImportTerrain, HgtIsBigEndianWithVoids) {
    std::string heights;
    for (const int h : {100, 100, 100, 100, -32768, 100, 100, 100, -5})
        heights += big_endian(static_cast<std::uint16_t>(h), 2);
    const auto model = import_text(heights, Format::terrain_hgt);
    ASSERT_TRUE(model.ok()) << model.error().message;
    testing::expect_sane(*model, "hgt");
    EXPECT_EQ(model->mesh.triangles.size(), 4u);  // one a cell: the middle is unknown
    EXPECT_EQ(model->mesh.positions.size(), 8u);
    EXPECT_FALSE(import_text(heights + "x", Format::terrain_hgt).ok());
}

TEST(ImportTerrain, HgtCellsNarrowWithTheLatitudeOfTheName) {
    const auto folder = std::filesystem::temp_directory_path() / "lodestream_importer_hgt";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "N60E010.hgt", std::ios::binary) << std::string(8, '\0');
    const auto model = import_file(folder / "N60E010.hgt");
    std::filesystem::remove_all(folder);
    ASSERT_TRUE(model.ok()) << model.error().message;
    float east = 0, south = 0;
    for (const Vec3f& p : model->mesh.positions) {
        east = std::max(east, p.x);
        south = std::max(south, p.z);
    }
    EXPECT_NEAR(east / south, std::cos(radians(60.5)), 1e-4);
    EXPECT_NEAR(south, 111'133, 1);
}

TEST(ImportTerrain, AscKeepsItsPlaceAndLeavesHolesOpen) {
    const auto model = import_text(
        "ncols 3\nnrows 2\nxllcorner 77665\nyllcorner 218635\ncellsize 10\nNODATA_value -1\n"
        "5 6 7\n8 9 -1\n",
        Format::terrain_asc);
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->mesh.triangles.size(), 3u);
    Box world;
    for (const Vec3f& p : model->mesh.positions) world.add(Vec3d(p) + model->origin);
    EXPECT_EQ(world.min.x, 77670);
    EXPECT_EQ(world.max.z, -218640);  // the southern row, and south is +z
    EXPECT_EQ(world.min.z, -218650);
    EXPECT_EQ(world.max.y, 9);
}

TEST(ImportTerrain, AscRefusesWhatItCannotHold) {
    const auto error = [](const std::string& text) { return import_text(text, Format::terrain_asc).error().message; };
    EXPECT_THAT(error("ncols 10000\nnrows 400\ncellsize 1\n1 2\n"), HasSubstr("more heights than its size"));
    EXPECT_THAT(error("ncols 1e8\nnrows 1e8\ncellsize 1\n1 2\n"), HasSubstr("limit"));
    EXPECT_THAT(error("ncols 2\nnrows 2\ncellsize 1\n1 2 3     \n"), HasSubstr("4 heights but holds 3"));
    EXPECT_THAT(error("ncols 2\nnrows 2\n1 2 3 4\n"), HasSubstr("no cell size"));
    EXPECT_THAT(error("ncols 2\nnrows 2\ncellsize 0\n1 2 3 4\n"), HasSubstr("no cell size"));
    EXPECT_THAT(error("ncols 2\nnrows 2\ncellsize 1\nNODATA_value 1\n1 1 1 1\n"), HasSubstr("0 heights but no cell"));
    EXPECT_THAT(error("ncols two\n"), HasSubstr("no number for ncols"));
}

}  // namespace
}  // namespace lodestream::importer
