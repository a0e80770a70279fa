#include "server/cli/files.h"

#include <fstream>
#include <functional>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "server/bake/bake.h"
#include "server/bake/stopwatch.h"
#include "server/cli/ply_writer.h"

namespace lodestream::cli {

namespace {

Result<std::vector<std::byte>> encode_glb(const mesh::Model& model, double error, const std::string& extras_json,
                                          Written& written) {
    const std::vector<std::uint8_t> all_gouraud(model.mesh.triangles.size(), 1);
    codec::EncodeOptions options = bake::level_options(mesh::bounds(model.mesh), model.mesh, {error, error});
    options.extras_json = extras_json;
    Result<codec::Encoded> encoded = codec::encode_level(model, model.mesh, all_gouraud, options);
    if (!encoded) return encoded.error();
    written.triangles = encoded->triangles;
    written.vertices = encoded->vertices;
    return std::move(encoded->glb);
}

// Writes what one of the two makes, by the extension of `file`.
Result<Written> write_either(const std::filesystem::path& file, Written& written,
                             const std::function<Result<std::vector<std::byte>>()>& glb,
                             const std::function<std::vector<std::byte>()>& ply) {
    const bake::Stopwatch watch;
    Result<std::vector<std::byte>> bytes =
        invalid_input("cannot write '" + file.string() + "': the name must end in .glb or .ply");
    if (file.extension() == ".glb") bytes = glb();
    if (file.extension() == ".ply") bytes = ply();
    if (!bytes) return bytes.error();
    written.encode_ms = watch.ms();
    written.bytes = bytes->size();
    if (Status done = write_file(file, *bytes); !done) return done.error();
    return written;
}

}  // namespace

Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    std::error_code ignored;
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return fail(ErrorCode::io, "cannot write " + file.string());
    return Nothing{};
}

Result<Written> write_model(const std::filesystem::path& file, const mesh::Model& model, double error,
                            const std::string& extras_json) {
    Written written{model.mesh.triangles.size(), model.mesh.positions.size(), 0, 0.0};
    return write_either(
        file, written, [&] { return encode_glb(model, error, extras_json, written); },
        [&] { return write_ply(model); });
}

Result<Written> write_points(const std::filesystem::path& file, const codec::Points& points) {
    Written written{0, points.cloud.positions.size(), 0, 0.0};
    const auto glb = [&]() -> Result<std::vector<std::byte>> {
        Result<codec::EncodedPoints> encoded = codec::encode_points(points);
        if (!encoded) return encoded.error();
        return std::move(encoded->glb);
    };
    const auto ply = [&] {
        mesh::Model model;
        model.mesh.positions = points.cloud.positions;
        model.mesh.normals = points.cloud.normals;
        model.mesh.colors = points.cloud.colors;
        model.origin = points.origin;
        return write_ply(model);
    };
    return write_either(file, written, glb, ply);
}

}  // namespace lodestream::cli
