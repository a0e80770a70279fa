#include "tests/client/render/fake/glsl_interface.h"

#include <algorithm>
#include <regex>
#include <sstream>

namespace lodestream::testing {
namespace {

using Defines = std::map<std::string, std::string>;

// "NAME", or "defined(A) || defined(B)".
bool holds(const std::string& condition, const Defines& defines) {
    static const std::regex name(R"(\b(?!defined\b)[A-Za-z_]\w*)");
    for (std::sregex_iterator it(condition.begin(), condition.end(), name), end; it != end; ++it)
        if (defines.contains(it->str())) return true;
    return false;
}

// One #if … #endif.
struct Conditional {
    bool is_on = false;   // its lines at hand count
    bool was_on = false;  // some branch of it counted
};

// The lines that count, without comments and directives.
Result<std::string> preprocess(const std::string& source, Defines& defines, std::string& version) {
    std::vector<Conditional> open;
    std::string out;
    std::istringstream lines(source);
    for (std::string line; std::getline(lines, line);) {
        line = line.substr(0, line.find("//"));
        std::istringstream words(line);
        std::string directive, rest;
        words >> directive >> std::ws;
        std::getline(words, rest);
        const bool counts = std::all_of(open.begin(), open.end(), [](const Conditional& c) { return c.is_on; });
        if (directive == "#ifdef" || directive == "#if") {
            const bool is_on = holds(rest, defines);
            open.push_back({is_on, is_on});
        } else if (directive == "#elif" || directive == "#else") {
            if (open.empty()) return invalid_input(directive + " without #if");
            open.back().is_on = !open.back().was_on && (directive == "#else" || holds(rest, defines));
            open.back().was_on = open.back().was_on || open.back().is_on;
        } else if (directive == "#endif") {
            if (open.empty()) return invalid_input("#endif without #if");
            open.pop_back();
        } else if (!counts) {
            continue;
        } else if (directive == "#version") {
            version = rest;
        } else if (directive == "#define") {
            const std::size_t name_end = std::min(rest.find(' '), rest.size());
            defines[rest.substr(0, name_end)] = rest.substr(std::min(name_end + 1, rest.size()));
        } else if (directive.starts_with("#")) {
            return invalid_input("unknown directive " + directive);
        } else {
            out += line + "\n";
        }
    }
    if (!open.empty()) return invalid_input("#if without #endif");
    return out;
}

bool brackets_close(const std::string& text) {
    std::string open;
    for (const char c : text) {
        const std::size_t opening = std::string_view("({[").find(c), closing = std::string_view(")}]").find(c);
        if (opening != std::string_view::npos) open += ")}]"[opening];
        if (closing == std::string_view::npos) continue;
        if (open.empty() || open.back() != c) return false;
        open.pop_back();
    }
    return open.empty();
}

std::size_t elements_of(const std::string& size, const Defines& defines) {
    if (size.empty()) return 1;
    const auto defined = defines.find(size);
    return std::stoul(defined == defines.end() ? size : defined->second);
}

}  // namespace

std::size_t components_of(std::string_view type) {
    if (type == "mat4") return 16;
    if (type == "mat3") return 9;
    return type.starts_with("vec") || type.starts_with("ivec") ? static_cast<std::size_t>(type.back() - '0') : 1;
}

Result<GlslInterface> glsl_interface(const std::string& source) {
    GlslInterface out;
    Defines defines;
    const auto text = preprocess(source, defines, out.version);
    if (!text) return text.error();
    if (!brackets_close(*text)) return invalid_input("a bracket does not close");
    if (text->find("void main()") == std::string::npos) return invalid_input("no main");
    static const std::regex declaration(
        R"((?:^|\n)\s*(?:layout\(location = (\d+)\) )?(flat )?(uniform|in|out) (\w+) (\w+)(?:\[(\w+)\])?;)");
    for (std::sregex_iterator it(text->begin(), text->end(), declaration), end; it != end; ++it) {
        const std::smatch& match = *it;
        const GlslVariable variable{match[4], match[2].matched, match[1].matched ? std::stoi(match[1]) : -1,
                                    elements_of(match[6], defines)};
        (match[3] == "uniform" ? out.uniforms : match[3] == "in" ? out.ins : out.outs)[match[5]] = variable;
    }
    return out;
}

}  // namespace lodestream::testing
