#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "common/motion/motion.h"

namespace lodestream::motion {

namespace {

constexpr std::string_view heading = "t_s,x,y,z,yaw_deg,pitch_deg";
constexpr std::size_t columns = 6;
constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

// Cuts the part before the next `end` off `text`.
std::string_view take(std::string_view& text, char end) {
    const std::size_t at = std::min(text.find(end), text.size());
    const std::string_view part = text.substr(0, at);
    text.remove_prefix(std::min(at + 1, text.size()));
    return trimmed(part);
}

std::optional<double> number(std::string_view text) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

Result<std::array<std::string_view, columns>> split(std::string_view row) {
    std::array<std::string_view, columns> cells;
    if (static_cast<std::size_t>(std::count(row.begin(), row.end(), ',')) + 1 != columns)
        return invalid_input("a row is " + std::string(heading));
    for (std::string_view& cell : cells) cell = take(row, ',');
    return cells;
}

Result<std::optional<Vec3d>> position_of(const std::array<std::string_view, columns>& cells) {
    if (cells[1].empty() && cells[2].empty() && cells[3].empty()) return std::optional<Vec3d>();
    const auto x = number(cells[1]), y = number(cells[2]), z = number(cells[3]);
    if (!x || !y || !z) return invalid_input("x, y and z are three finite numbers or all empty");
    return std::optional<Vec3d>(Vec3d{*x, *y, *z});
}

Result<Sample> parse_row(std::string_view row) {
    const auto cells = split(row);
    if (!cells) return cells.error();
    const auto position = position_of(*cells);
    if (!position) return position.error();
    const auto t_s = number((*cells)[0]), yaw = number((*cells)[4]), pitch = number((*cells)[5]);
    if (!t_s || !yaw || !pitch) return invalid_input("t_s, yaw_deg and pitch_deg must be finite numbers");
    if (std::abs(*pitch) > max_pitch_deg) return invalid_input("pitch_deg must lie between -90 and 90");
    return Sample{*t_s, {*position, *yaw, *pitch}};
}

}  // namespace

Result<Trace> parse_csv(std::string_view text) {
    Trace trace;
    for (std::size_t line = 1; !text.empty(); ++line) {
        const std::string_view row = take(text, '\n');
        if (row.empty() || (trace.empty() && row == heading)) continue;
        const std::string where = "motion, line " + std::to_string(line) + ": ";
        const auto sample = parse_row(row);
        if (!sample) return fail(sample.error().code, where + sample.error().message);
        if (!trace.empty() && !(sample->t_s > trace.back().t_s))
            return invalid_input(where + "t_s must be larger than in the row before");
        if (trace.size() == max_samples)
            return fail(ErrorCode::limit_exceeded, where + "more than " + std::to_string(max_samples) + " rows");
        trace.push_back(*sample);
    }
    if (trace.empty()) return invalid_input("motion: no row of " + std::string(heading));
    return trace;
}

}  // namespace lodestream::motion
