#include "server/samples/samples.h"

#include <charconv>
#include <optional>
#include <string>

namespace lodestream::samples {
namespace {

struct Spec {
    std::string_view name;
    std::optional<std::uint64_t> count;
};

Error wrong_spec(std::string_view spec) {
    return invalid_input(
        "sample \"" + std::string(spec.substr(0, 40)) +
        "\" is not known: write teapot[:triangles], terrain[:vertices], ship[:objects] or fine-ship[:objects]");
}

std::optional<Spec> parse(std::string_view spec) {
    const std::size_t colon = spec.find(':');
    if (colon == std::string_view::npos) return Spec{spec, std::nullopt};
    const std::string_view digits = spec.substr(colon + 1);
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
    if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    return Spec{spec.substr(0, colon), count};
}

}  // namespace

Result<mesh::Model> make_sample(std::string_view spec) {
    const auto parsed = parse(spec);
    if (parsed && parsed->name == "teapot") return teapot(parsed->count.value_or(teapot_triangles));
    if (parsed && parsed->name == "terrain") return terrain(parsed->count.value_or(terrain_vertices));
    if (parsed && parsed->name == "ship") return ship(parsed->count.value_or(ship_objects));
    if (parsed && parsed->name == "fine-ship") return fine_ship(parsed->count.value_or(max_ship_objects));
    return wrong_spec(spec);
}

}  // namespace lodestream::samples
