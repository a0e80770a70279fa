#include "server/cli/files.h"

#include <chrono>
#include <fstream>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "server/bake/bake.h"
#include "server/cli/ply_writer.h"

namespace lodestream::cli {

namespace {

Result<std::vector<std::byte>> encode_glb(const mesh::Model& model, double error, const std::string& extras_json,
                                          Written& written) {
    const std::vector<std::uint8_t> all_gouraud(model.mesh.triangles.size(), 1);
    codec::EncodeOptions options;
    options.grid = codec::choose_grid(mesh::bounds(model.mesh), error, bake::mean_edge_length(model.mesh));
    options.extras_json = extras_json;
    Result<codec::Encoded> encoded = codec::encode_level(model, model.mesh, all_gouraud, options);
    if (!encoded) return encoded.error();
    written.triangles = encoded->triangles;
    written.vertices = encoded->vertices;
    return std::move(encoded->glb);
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
    const auto start = std::chrono::steady_clock::now();
    Written written{model.mesh.triangles.size(), model.mesh.positions.size(), 0, 0.0};
    std::vector<std::byte> bytes;
    if (file.extension() == ".glb") {
        Result<std::vector<std::byte>> glb = encode_glb(model, error, extras_json, written);
        if (!glb) return glb.error();
        bytes = std::move(*glb);
    } else if (file.extension() == ".ply") {
        bytes = write_ply(model);
    } else {
        return invalid_input("cannot write '" + file.string() + "': the name must end in .glb or .ply");
    }
    written.encode_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    written.bytes = bytes.size();
    if (Status done = write_file(file, bytes); !done) return done.error();
    return written;
}

}  // namespace lodestream::cli
