#include "server/bake/limits.h"

#include <unistd.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/mesh/instances.h"
#include "server/bake/shapes.h"

namespace lodestream::bake {

namespace {

template <class T>
std::uint64_t bytes_of(const std::vector<T>& vector) {
    return vector.size() * sizeof(T);
}

std::uint64_t bytes_of(const mesh::Mesh& mesh) {
    return bytes_of(mesh.positions) + bytes_of(mesh.normals) + bytes_of(mesh.texture_coordinates) +
           bytes_of(mesh.colors) + bytes_of(mesh.triangles) + bytes_of(mesh.triangle_materials) +
           bytes_of(mesh.triangle_objects);
}

std::uint64_t machine_memory_bytes() {
    const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
    return pages > 0 && page_bytes > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes)
                                       : ~std::uint64_t{0};
}

std::string megabytes(std::uint64_t bytes) {
    return std::to_string(bytes / 1'000'000 + 1) + " MB";
}

}  // namespace

std::uint64_t memory_bytes(const mesh::Model& model) {
    std::uint64_t bytes = bytes_of(model.mesh) + bytes_of(model.instances);
    for (const mesh::Mesh& shape : model.shapes) bytes += bytes_of(shape);
    for (const mesh::Image& image : model.images) bytes += image.bytes.size();
    return bytes;
}

std::uint64_t bake_memory_bytes(const mesh::Model& model) {
    // Of instances only levels are ever in one mesh, which has at most three vertices a triangle.
    const std::uint64_t instanced = mesh::vertex_count(model) - model.mesh.positions.size();
    return 2 * memory_bytes(model) +
           bake_bytes_per_vertex * (model.mesh.positions.size() + std::min(instanced, 3 * max_whole_triangles));
}

Status check_memory(const mesh::Model& model, const Limits& limits) {
    const auto share = static_cast<std::uint64_t>(memory_share * static_cast<double>(machine_memory_bytes()));
    const std::uint64_t limit = limits.max_memory_bytes > 0 ? limits.max_memory_bytes : share;
    const std::uint64_t need = bake_memory_bytes(model);
    if (need <= limit) return Nothing{};
    return fail(ErrorCode::limit_exceeded,
                "its bake needs about " + megabytes(need) + " of memory, more than the limit of " + megabytes(limit));
}

}  // namespace lodestream::bake
