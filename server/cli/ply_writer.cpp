#include "server/cli/ply_writer.h"

#include <string>

namespace lodestream::cli {

namespace {

class Bytes {
  public:
    std::vector<std::byte> bytes;

    void text(const std::string& s) { raw(s.data(), s.size()); }
    template <class T>
    void number(T value) {
        raw(&value, sizeof value);
    }
    template <class Vector>
    void vector(const Vector& v) {
        raw(&v, sizeof v);
    }

  private:
    void raw(const void* data, std::size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        bytes.insert(bytes.end(), begin, begin + size);
    }
};

std::string header(const mesh::Mesh& mesh, bool far_away) {
    const std::string real = far_away ? "double" : "float";
    std::string h = "ply\nformat binary_little_endian 1.0\ncomment lodestream\nelement vertex " +
                    std::to_string(mesh.positions.size()) + "\n";
    for (const char* axis : {"x", "y", "z"}) h += "property " + real + " " + axis + "\n";
    if (!mesh.normals.empty()) h += "property float nx\nproperty float ny\nproperty float nz\n";
    if (!mesh.texture_coordinates.empty()) h += "property float s\nproperty float t\n";
    if (!mesh.colors.empty())
        h += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    return h + "element face " + std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar uint vertex_indices\nend_header\n";
}

}  // namespace

std::vector<std::byte> write_ply(const mesh::Model& model) {
    const mesh::Mesh& mesh = model.mesh;
    const bool far_away = model.origin != Vec3d{0.0};
    Bytes out;
    out.text(header(mesh, far_away));
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        if (far_away)
            out.vector(Vec3d(mesh.positions[v]) + model.origin);
        else
            out.vector(mesh.positions[v]);
        if (!mesh.normals.empty()) out.vector(mesh.normals[v]);
        if (!mesh.texture_coordinates.empty())
            out.vector(Vec2f{mesh.texture_coordinates[v].x, 1.0f - mesh.texture_coordinates[v].y});
        if (!mesh.colors.empty()) out.vector(mesh.colors[v]);
    }
    for (const mesh::Triangle& t : mesh.triangles) {
        out.number(std::uint8_t{3});
        for (const std::uint32_t v : t) out.number(v);
    }
    return std::move(out.bytes);
}

}  // namespace lodestream::cli
