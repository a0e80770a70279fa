// libFuzzer over a model's whole way through a bake: import, record, cut at several budgets, store, open, cut again.
// The first byte picks the format, the second the budgets, the rest is the file. See run.sh.
#include <algorithm>
#include <cstdlib>

#include "common/codec/points_codec.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/points/level.h"
#include "common/points/order.h"
#include "common/simplify/history.h"
#include "server/bake/baked_model.h"
#include "server/importer/importer.h"

namespace {

using namespace lodestream;

constexpr std::uint64_t max_elements = 20'000;  // vertices and triangles: enough for every rule of the engine

void require(bool holds) {
    if (!holds) std::abort();
}

void require_sane(const mesh::Mesh& level, std::size_t materials) {
    const std::size_t n = level.positions.size();
    for (const Vec3f& p : level.positions) require(all_finite(p));
    for (const Vec3f& v : level.normals) require(all_finite(v));
    require(level.normals.empty() || level.normals.size() == n);
    require(level.texture_coordinates.empty() || level.texture_coordinates.size() == n);
    require(level.colors.empty() || level.colors.size() == n);
    for (const mesh::Triangle& t : level.triangles)
        for (const std::uint32_t v : t) require(v < n);
    require(level.triangle_materials.empty() || level.triangle_materials.size() == level.triangles.size());
    for (const std::uint32_t m : level.triangle_materials) require(m < materials);
}

// The count asked for is reached but for the pairs that closed surfaces lose.
void require_cut(const simplify::HistoryView& history, std::uint64_t budget, std::size_t materials) {
    const mesh::Mesh level = simplify::cut(history, budget);
    require_sane(level, materials);
    require(level.triangles.size() <= budget);
    require(level.triangles.size() == simplify::triangles_within(history, budget));
}

void bake_model(mesh::Model model, std::uint64_t seed) {
    const std::size_t materials = model.materials.size(), triangles = model.mesh.triangles.size();
    bake::BakedModel baked = bake::describe_model(model);
    Result<simplify::History> history = simplify::record_history(std::move(model.mesh));
    require(history.ok());
    require(simplify::validate(simplify::view(*history)).ok());
    require(simplify::triangle_count(simplify::view(*history)) <= triangles);

    bake::set_history(baked, *std::move(history));
    baked.errors = {{simplify::triangle_count(simplify::view(baked.history)), {}}};
    const std::vector<std::byte> bytes = bake::serialize(baked);
    const Result<bake::BakedView> opened = bake::open_baked_model(bytes);
    require(opened.ok());
    for (const std::uint64_t budget :
         {std::uint64_t{1}, std::uint64_t{2}, 1 + seed % 7, 1 + triangles * seed / 256, triangles / 2 + 1, triangles})
        require_cut(opened->history, budget, materials);
}

// A cloud's points keep apart in every order and are written and read whole.
void bake_cloud(const mesh::Model& model, std::uint64_t seed) {
    const points::PointCloud cloud{model.mesh.positions, model.mesh.normals, model.mesh.colors};
    points::OrderedCloud ordered = points::order(cloud, 1 + cloud.positions.size() * seed / 256);
    require(!ordered.cloud.positions.empty());
    const mesh::Mesh points = points::as_mesh(cloud);
    codec::Points content;
    content.levels = points::measured_levels(metric::SurfaceIndex(points), points, ordered);
    content.cloud = std::move(ordered.cloud);
    content.grid = codec::point_grid(mesh::bounds(points));
    content.origin = model.origin;
    const Result<codec::EncodedPoints> encoded = codec::encode_points(content);
    require(encoded.ok());
    const Result<codec::DecodedPoints> decoded = codec::decode_points(encoded->glb);
    require(decoded.ok());
    require(decoded->points == content.cloud.positions.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    constexpr int formats = static_cast<int>(importer::Format::terrain_asc) + 1;
    const auto format = static_cast<importer::Format>(data[0] % formats);
    importer::Limits limits;
    limits.vertices = limits.triangles = max_elements;
    const auto* bytes = reinterpret_cast<const std::byte*>(data + 2);
    Result<mesh::Model> model = importer::import_model({bytes, size - 2}, format, importer::no_side_files(), limits);
    if (!model) return 0;
    if (model->kind == mesh::Kind::points)
        bake_cloud(*model, data[1]);
    else
        bake_model(mesh::without_instances(*std::move(model)), data[1]);
    return 0;
}
