#include "server/importer/importer.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "server/importer/printable.h"
#include "tests/server/importer/inputs.h"

namespace lodestream::importer {
namespace {

namespace fs = std::filesystem;
using testing::bytes_of;
using ::testing::HasSubstr;
using testing::import_text;

TEST(Importer, KnowsExtensionsInAnyCase) {
    EXPECT_EQ(format_of_extension("a/b.OBJ").value(), Format::obj);
    EXPECT_EQ(format_of_extension("x.gLb").value(), Format::glb);
    EXPECT_EQ(format_of_extension("x.Hgt").value(), Format::terrain_hgt);
    EXPECT_EQ(format_of_extension("x.fbx").error().code, ErrorCode::unsupported);
    EXPECT_THAT(format_of_extension("x.fbx").error().message, HasSubstr("fbx"));
    EXPECT_FALSE(format_of_extension("noextension").ok());
}

TEST(Importer, SniffsContent) {
    const auto sniff = [](std::string_view text) { return sniff_format(bytes_of(text)); };
    EXPECT_EQ(sniff("glTF\2\0\0\0").value(), Format::glb);
    EXPECT_EQ(sniff("DRACO\2\2").value(), Format::drc);
    EXPECT_EQ(sniff("\x89PNG\r\n\x1a\n").value(), Format::terrain_png);
    EXPECT_EQ(sniff("\xEF\xBB\xBF {\"asset\":{}}").value(), Format::gltf);
    EXPECT_EQ(sniff("ply\r\nformat").value(), Format::ply);
    EXPECT_EQ(sniff("solid x\n facet").value(), Format::stl);
    EXPECT_EQ(sniff("# c\nCOFF\n").value(), Format::off);
    EXPECT_EQ(sniff("ncols 3\n").value(), Format::terrain_asc);
    EXPECT_EQ(sniff("# Blender\r\n\r\nmtllib x.mtl\r\n").value(), Format::obj);
    std::string stl(80, 'x');
    stl += std::string("\1\0\0\0", 4) + std::string(50, '\0');
    EXPECT_EQ(sniff(stl).value(), Format::stl);
    EXPECT_EQ(sniff(std::string(1201 * 1201 * 2, '\0')).value(), Format::terrain_hgt);
    for (const char* text : {"", "hello world", "\x7f\x45LF", "<html>"})
        EXPECT_EQ(sniff(text).error().code, ErrorCode::unsupported);
}

class SideFilesTest : public ::testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder / "model" / "textures");
        write(folder / "secret.txt", "secret");
        write(folder / "model" / "textures" / "a b.png", "image");
        write(folder / "model-two.txt", "neighbour");
        fs::create_symlink(folder / "secret.txt", folder / "model" / "link.txt");
    }
    void TearDown() override { fs::remove_all(folder); }
    static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

    const fs::path folder = fs::temp_directory_path() / ("lodestream_side_files_" + std::to_string(::getpid()));
    const SideFiles read_side_file = read_files_below(folder / "model", 1000);
};

TEST_F(SideFilesTest, ReadsFilesBelowTheModel) {
    EXPECT_EQ(read_side_file("textures/a b.png").value(), bytes_of("image"));
    EXPECT_EQ(read_side_file("./textures/../textures/a b.png").value(), bytes_of("image"));
}

TEST_F(SideFilesTest, RefusesToLeaveTheModelsFolder) {
    for (const std::string& name : std::vector<std::string>{
             "../secret.txt", "textures/../../secret.txt", "../model-two.txt", "/etc/passwd", "http://x/y.png",
             "file:///etc/passwd", "data:text/plain;base64,AA", "link.txt", "", ".", "..", "textures"}) {
        const auto bytes = read_side_file(name);
        ASSERT_FALSE(bytes.ok()) << name;
        EXPECT_EQ(bytes.error().code, ErrorCode::invalid_input) << name << ": " << bytes.error().message;
    }
    EXPECT_EQ(read_side_file(std::string("textures/a b.png\0x", 18)).error().code, ErrorCode::invalid_input);
}

TEST_F(SideFilesTest, NamesWhatIsMissingOrTooLarge) {
    EXPECT_EQ(read_side_file("nothing.bin").error().code, ErrorCode::not_found);
    EXPECT_THAT(read_side_file("nothing.bin").error().message, HasSubstr("nothing.bin"));
    EXPECT_EQ(read_files_below(folder / "model", 3)("textures/a b.png").error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(no_side_files()("a.bin").error().code, ErrorCode::not_found);
}

TEST_F(SideFilesTest, ImportFileFindsItsSideFilesAndNamesItselfInErrors) {
    write(folder / "model" / "m.mtl", "newmtl a\nKd 1 0 0\n");
    write(folder / "model" / "m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto model = import_file(folder / "model" / "m.obj");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->materials[0].name, "a");
    write(folder / "model" / "bad.ply", "nonsense");
    EXPECT_THAT(import_file(folder / "model" / "bad.ply").error().message, ::testing::StartsWith("bad.ply: "));
    EXPECT_EQ(import_file(folder / "model" / "none.ply").error().code, ErrorCode::not_found);
    EXPECT_FALSE(import_file(folder / "model").ok());
    Limits small;
    small.file_bytes = 10;
    EXPECT_EQ(import_file(folder / "model" / "m.obj", small).error().code, ErrorCode::limit_exceeded);
}

TEST(Importer, HoldsItsLimits) {
    Limits small;
    small.triangles = 1;
    const char* two_triangles = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";
    EXPECT_EQ(import_text(two_triangles, Format::obj, no_side_files(), small).error().code, ErrorCode::limit_exceeded);
    small = {};
    small.vertices = 3;
    EXPECT_EQ(import_text(two_triangles, Format::obj, no_side_files(), small).error().code, ErrorCode::limit_exceeded);
    small = {};
    small.file_bytes = 4;
    EXPECT_EQ(import_text(two_triangles, Format::obj, no_side_files(), small).error().code, ErrorCode::limit_exceeded);
}

TEST(Importer, MessagesAndNamesArePrintableUtf8) {
    const auto model = import_text("ply\nelement vertex 1\nproperty \x01\x02\x1b[0m x\nend_header\n", Format::ply);
    ASSERT_FALSE(model.ok());
    for (const char c : model.error().message) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
    EXPECT_EQ(printable("a\nb"), "a?b");
    EXPECT_EQ(printable("\xec\x83\x81\xec\x9e\x90 \xf0\x9f\x98\x80"), "\xec\x83\x81\xec\x9e\x90 \xf0\x9f\x98\x80");
    for (const char* broken :
         {"\xff", "\xc3", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"})
        EXPECT_EQ(printable(broken), std::string(std::string(broken).size(), '?'));
}

TEST(Importer, EveryFormatRefusesEmptyAndShortInput) {
    for (const Format format : {Format::gltf, Format::glb, Format::obj, Format::ply, Format::stl, Format::off,
                                Format::drc, Format::terrain_png, Format::terrain_hgt, Format::terrain_asc})
        for (const std::string& text :
             std::vector<std::string>{"", "x", "{}", "glTF", "ply", "OFF", "\x89PNG", "DRACO"})
            EXPECT_FALSE(import_text(text, format).ok()) << static_cast<int>(format) << " " << text;
}

TEST(Importer, ManyWarningsAreCutShort) {
    std::string library, text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (int i = 0; i < 500; ++i)
        library += "newmtl m" + std::to_string(i) + "\nmap_Kd missing" + std::to_string(i) + ".png\n";
    const auto model = import_text(text, Format::obj, testing::files_in_memory({{"m.mtl", bytes_of(library)}}));
    ASSERT_TRUE(model.ok());
    EXPECT_LT(model.warnings.size(), 110u);
}

}  // namespace
}  // namespace lodestream::importer
