#include "common/shading/importance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/base/srgb.h"
#include "common/mesh/operations.h"
#include "common/shading/numbers.h"

namespace lodestream::shading {
namespace {

constexpr double small_angle = 0.01;        // radians, over which a display is taken as linear
constexpr double nearest_eye_share = 1e-2;  // of the longest edge: an eye in the triangle's plane or on a corner

// Linear light as an 8-bit sRGB display shows it, [0, 1] to [0, 1].
double displayed(double linear) {
    return srgb_of_light(std::clamp(finite_or_zero(linear), 0.0, 1.0));
}

// The steepest fall of cos^s over an angle, a radian: at tan²(angle) = 1/(s - 1). Unbounded below s = 1.
double steepest_slope(double shininess) {
    if (!(shininess > 1.0)) return 1e9;
    return std::sqrt(shininess) * std::pow((shininess - 1.0) / shininess, (shininess - 1.0) / 2.0);
}

// Parts of the greatest difference at a corner, before colour.
struct Parts {
    double diffuse = 0.0;
    double specular = 0.0;
};

double diffuse_part(double angle, const Phong& phong) {
    return phong.diffuse * (angle < pi / 2.0 ? std::sin(angle) : 1.0);
}

double specular_part(double angle, const Phong& phong, double slope) {
    return phong.specular * std::min(1.0, 2.0 * angle * slope);
}

double displayed_difference(const Parts& parts, double color, double darkest) {
    return displayed(darkest + color * parts.diffuse + parts.specular) - displayed(darkest);
}

// π where a normal is missing: then nothing is known of the difference.
double angle_between(const Vec3d& unit_a, const Vec3d& unit_b) {
    if (unit_a == Vec3d(0.0) || unit_b == Vec3d(0.0)) return pi;
    return std::atan2(glm::length(glm::cross(unit_a, unit_b)), glm::dot(unit_a, unit_b));
}

// One triangle and what its corners look like.
struct Face {
    std::array<Vec3d, 3> corners;
    std::array<Vec3d, 3> normals;
    std::array<Vec3d, 3> colors;
    Vec3d normal;  // turned to the side that the corners' normals point to, as it is drawn
    double area = 0.0;
    bool double_sided = false;
};

Face face_of(const mesh::Mesh& mesh, std::size_t triangle, const std::vector<mesh::Material>& materials) {
    const mesh::Triangle& t = mesh.triangles[triangle];
    const std::uint32_t material = material_of(mesh, triangle);
    const Vec3d base = base_color(materials, material);
    Face face;
    Vec3d sum(0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = t[i];
        face.corners[i] = Vec3d(mesh.positions[v]);
        face.normals[i] = v < mesh.normals.size() ? unit_or_zero(Vec3d(mesh.normals[v])) : Vec3d(0.0);
        face.colors[i] = mesh.colors.empty() ? base : base * Vec3d(mesh.colors[v]) / 255.0;
        sum += face.normals[i];
    }
    face.normal = mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    if (glm::dot(face.normal, sum) < 0.0) face.normal = -face.normal;
    face.area = finite_or_zero(mesh::face_area(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
    face.double_sided = material < materials.size() && materials[material].double_sided;
    return face;
}

// The solid angle that a small triangle covers, as seen from the eye; less where it shows its back, none behind the
// eye.
double seen_area(const Face& face, const View& view, const Vec3d& eye) {
    const Vec3d center = (face.corners[0] + face.corners[1] + face.corners[2]) / 3.0;
    const Vec3d to_eye = eye - center;
    if (glm::dot(unit_or_zero(view.target - view.eye), unit_or_zero(to_eye)) > 0.0) return 0.0;
    double longest = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
        longest = std::max(longest, glm::distance(face.corners[i], face.corners[(i + 1) % 3]));
    const double distance = std::max(glm::length(to_eye), nearest_eye_share * longest);
    const double facing = glm::dot(face.normal, unit_or_zero(to_eye));
    const double share = facing >= 0.0 || face.double_sided ? std::abs(facing) : -facing * turned_away_share;
    const double angle = face.area / distance / distance * share;
    return std::min(finite_or_zero(angle), 2.0 * pi);
}

// The share of the difference that is gained; see importance.h.
double share_gained(const Face& face) {
    Vec3d sum(0.0);
    double squares = 0.0, along_edges = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        if (face.normals[i] == Vec3d(0.0)) return 1.0;  // nothing is known
        const Vec3d off = face.normals[i] - face.normal;
        sum += off;
        squares += glm::dot(off, off);
        const std::size_t next = (i + 1) % 3;
        const Vec3d edge = unit_or_zero(face.corners[next] - face.corners[i]);
        const double q = 0.5 * glm::dot(edge, face.normals[i] + face.normals[next]);
        along_edges += q * q;
    }
    const double total = squares + glm::dot(sum, sum);
    return total > 0.0 ? std::max(-1.0, 1.0 - 16.0 * along_edges / total) : 0.0;
}

// One criterion over a whole mesh.
class Evaluation {
  public:
    Evaluation(const ImportanceOptions& options, OperationCounts& counts)
        : options_(options),
          counts_(counts),
          slope_(steepest_slope(options.phong.shininess)),
          eye_(options.view ? options.view->eye - options.origin : Vec3d(0.0)) {}

    // The solid angle or area that a triangle counts with.
    double size(const Face& face) {
        ++counts_.sizes;
        return options_.view ? seen_area(face, *options_.view, eye_) : face.area;
    }

    // The greatest difference, mean square over the triangle.
    double difference(const Face& face) {
        const double darkest = ambient();
        std::array<Parts, 3> parts;
        for (std::size_t i = 0; i < 3; ++i) {
            const double angle = angle_between(face.normals[i], face.normal);
            parts[i] = {diffuse(angle), specular(angle)};
        }
        return mean_square(face, parts, darkest);
    }

    // What the display makes of a normal's squared error.
    double squared_slope(const Face& face) const {
        const double ambient = options_.phong.ambient;
        const Parts parts{diffuse_part(small_angle, options_.phong),
                          specular_part(small_angle, options_.phong, slope_)};
        double sum = 0.0;
        for (int channel = 0; channel < 3; ++channel) {
            const double color = mean_color(face, channel);
            const double step = displayed_difference(parts, color, color * ambient) / small_angle;
            sum += step * step;
        }
        return finite_or_zero(sum / 3.0);
    }

  private:
    double ambient() {
        ++counts_.ambient;
        return options_.phong.ambient;
    }
    double diffuse(double angle) {
        ++counts_.diffuse;
        return diffuse_part(angle, options_.phong);
    }
    double specular(double angle) {
        ++counts_.specular;
        return specular_part(angle, options_.phong, slope_);
    }
    double mean_square(const Face& face, const std::array<Parts, 3>& parts, double ambient) {
        ++counts_.comparisons;
        double channel_sum = 0.0, sum = 0.0;
        for (int channel = 0; channel < 3; ++channel) {
            if (channel == 0 || !alike(face, channel - 1, channel))
                channel_sum = step_squares(face, parts, ambient, channel);
            sum += channel_sum;
        }
        return finite_or_zero(sum / 36.0);
    }

    static double mean_color(const Face& face, int channel) {
        double sum = 0.0;
        for (const Vec3d& color : face.colors) sum += std::clamp(finite_or_zero(color[channel]), 0.0, 1.0);
        return sum / 3.0;
    }

    // Of grey corners one channel says all.
    static bool alike(const Face& face, int channel, int other) {
        return std::all_of(face.colors.begin(), face.colors.end(),
                           [&](const Vec3d& color) { return color[channel] == color[other]; });
    }

    static double step_squares(const Face& face, const std::array<Parts, 3>& parts, double ambient, int channel) {
        double sum = 0.0, squares = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double color = std::clamp(finite_or_zero(face.colors[i][channel]), 0.0, 1.0);
            const double step = displayed_difference(parts[i], color, color * ambient);
            sum += step;
            squares += step * step;
        }
        return squares + sum * sum;
    }

    const ImportanceOptions& options_;
    OperationCounts& counts_;
    double slope_;
    Vec3d eye_;
};

}  // namespace

double greatest_difference(double degrees_apart, double color, const Phong& phong) {
    const double angle = std::clamp(finite_or_zero(degrees_apart), 0.0, 180.0) * pi / 180.0;
    const Parts parts{diffuse_part(angle, phong), specular_part(angle, phong, steepest_slope(phong.shininess))};
    return displayed_difference(parts, color, color * phong.ambient);
}

Importance importance(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials,
                      const ImportanceOptions& options) {
    Importance result;
    Evaluation evaluate(options, result.operations);
    result.difference.reserve(mesh.triangles.size());
    result.gain.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Face face = face_of(mesh, t, materials);
        const double size = evaluate.size(face), difference = size * evaluate.difference(face);
        result.difference.push_back(difference);
        if (options.errors) {
            const double weight = size * evaluate.squared_slope(face);
            result.gain.push_back(weight * (options.errors->flat[t] - options.errors->gouraud[t]));
            result.facet_error += weight * options.errors->flat[t];
        } else {
            result.gain.push_back(difference * share_gained(face));
            result.facet_error += difference;
        }
    }
    return result;
}

std::vector<std::uint32_t> order_by_gain(std::span<const double> gain) {
    std::vector<std::uint32_t> order(gain.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return gain[a] > gain[b]; });
    return order;
}

std::vector<double> difference_left(std::span<const double> difference, std::span<const std::uint32_t> order) {
    std::vector<double> left(order.size() + 1, 0.0);
    for (std::size_t i = order.size(); i-- > 0;) left[i] = left[i + 1] + difference[order[i]];
    return left;
}

std::uint64_t worth_gouraud(const Importance& importance) {
    const double mean = importance.facet_error / static_cast<double>(importance.gain.size());
    return static_cast<std::uint64_t>(std::count_if(importance.gain.begin(), importance.gain.end(), [&](double gain) {
        return gain > least_gain_in_mean_errors * mean;
    }));
}

}  // namespace lodestream::shading
