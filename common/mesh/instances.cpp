#include "common/mesh/instances.h"

#include <utility>

#include "common/mesh/operations.h"

namespace lodestream::mesh {

std::uint64_t triangle_count(const Model& model) {
    std::uint64_t count = model.mesh.triangles.size();
    for (const Instance& instance : model.instances) count += model.shapes[instance.shape].triangles.size();
    return count;
}

std::uint64_t vertex_count(const Model& model) {
    std::uint64_t count = model.mesh.positions.size();
    for (const Instance& instance : model.instances) count += model.shapes[instance.shape].positions.size();
    return count;
}

Box bounds(const Model& model) {
    Box box = bounds(model.mesh);
    for (const Instance& instance : model.instances) {
        const Box own = bounds(model.shapes[instance.shape], instance);
        box.add(own.min);
        box.add(own.max);
    }
    return box;
}

Mesh placed(const Mesh& shape, const Instance& instance) {
    return placed(shape, Vec3d(0.0), instance.matrix);
}

Box bounds(const Mesh& shape, const Instance& instance) {
    Mesh surface;
    surface.positions = shape.positions;
    surface.triangles = shape.triangles;
    return bounds(placed(std::move(surface), Vec3d(0.0), instance.matrix));
}

Mesh flattened(const Model& model, std::span<const Mesh> shapes) {
    Mesh all = model.mesh;
    for (const Instance& instance : model.instances) {
        Mesh own = placed(shapes[instance.shape], instance);
        own.triangle_objects.assign(own.triangles.size(), instance.object);
        append(all, own);
    }
    return all;
}

Model without_instances(Model model) {
    model.mesh = flattened(model, model.shapes);
    model.shapes.clear();
    model.instances.clear();
    return model;
}

}  // namespace lodestream::mesh
