// Says how far a level is from the full model: as surfaces, and as pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "client/render/gl_context.h"
#include "client/render/image.h"
#include "client/render/renderer.h"
#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/shading/view.h"

namespace lodestream::bench {

inline constexpr std::uint32_t picture_side = 800;  // px

// From the eight corners of a box around the model in world coordinates, lit from over the viewer's shoulder; the
// model's sphere fills the picture.
std::vector<shading::View> views_around(const mesh::Model& model);
// Likewise from the 26 directions to a cube's faces, edges and corners.
std::vector<shading::View> views_from_26(const mesh::Model& model);

struct ImageError {
    double rms = 0.0;                 // 8-bit steps over R, G and B, over all views' covered pixels
    double silhouette_percent = 0.0;  // of all views. covered pixels
};

// Draws in software or on a GPU, whichever there is. One thread only.
class Painter {
  public:
    static Result<Painter> create();

    // One picture a view, Gouraud shaded where the mesh has normals. Throws std::runtime_error where the driver
    // refuses.
    std::vector<render::Image> draw(const mesh::Model& model, const mesh::Mesh& level,
                                    const std::vector<shading::View>& views);
    std::vector<render::Image> draw(const codec::Decoded& content, const std::vector<shading::View>& views);

  private:
    Painter(render::GlContext context, render::Renderer renderer)
        : context_(std::move(context)), renderer_(std::move(renderer)) {}

    render::GlContext context_;
    render::Renderer renderer_;  // goes before the context
};

// The full model's pictures beside those of its levels. Throws like Painter, and where a file cannot be written.
class Gallery {
  public:
    Gallery(Painter& painter, const mesh::Model& model)  // both must outlive it
        : Gallery(painter, model, views_around(model)) {}
    Gallery(Painter& painter, const mesh::Model& model, std::vector<shading::View> views);

    ImageError show(const mesh::Mesh& level) { return show(model_, level); }
    ImageError show(const mesh::Model& level) { return show(level, level.mesh); }  // of materials of its own
    // One view of a level whose triangles are Gouraud where labelled.
    double show_split(const mesh::Mesh& level, const std::vector<std::uint8_t>& gouraud, std::size_t view);
    // The first view of the full model and of all levels shown since the last time, side by side.
    void write(const std::filesystem::path& file);

  private:
    ImageError show(const mesh::Model& materials, const mesh::Mesh& level);

    Painter& painter_;
    const mesh::Model& model_;
    std::vector<shading::View> views_;
    std::vector<render::Image> full_, shown_;
};

}  // namespace lodestream::bench
