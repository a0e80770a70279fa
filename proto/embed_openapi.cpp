// Build tool: embed_openapi IN.yaml OUT.cpp writes the YAML document as JSON inside a C++ source. An example's
// externalValue, a file beside the document, becomes its value. Only plain scalars may be numbers, booleans or null
// (YAML 1.2's core schema); quoted ones are strings whatever they say.
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>

namespace {

using Json = nlohmann::ordered_json;

Json scalar(const YAML::Node& node) {
    static const std::regex whole("[-+]?[0-9]+");
    static const std::regex real("[-+]?(\\.[0-9]+|[0-9]+(\\.[0-9]*)?)([eE][-+]?[0-9]+)?");
    const std::string& text = node.Scalar();
    if (node.Tag() != "?") return text;
    if (text == "true" || text == "false") return text == "true";
    if (std::regex_match(text, whole)) return std::stoll(text);
    if (std::regex_match(text, real)) return std::stod(text);
    return text;
}

Json read_json(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    return Json::parse(in);
}

Json json_of(const YAML::Node& node, const std::filesystem::path& folder) {
    if (node.IsMap()) {
        Json object = Json::object();
        for (const auto& member : node) {
            const std::string& name = member.first.Scalar();
            if (name == "externalValue")
                object["value"] = read_json(folder / member.second.Scalar());
            else
                object[name] = json_of(member.second, folder);
        }
        return object;
    }
    if (node.IsSequence()) {
        Json array = Json::array();
        for (const YAML::Node& item : node) array.push_back(json_of(item, folder));
        return array;
    }
    return node.IsNull() ? Json(nullptr) : scalar(node);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::cerr << "usage: embed_openapi IN.yaml OUT.cpp\n";
        return 2;
    }
    try {
        const std::filesystem::path document = argv[1];
        const Json json = json_of(YAML::LoadFile(document), document.parent_path());
        std::ofstream out(argv[2], std::ios::binary);
        out << "#include \"proto/openapi.h\"\n\nnamespace lodestream::proto {\n\nstd::string_view openapi_json() {\n"
            << "    return R\"openapi(" << json.dump() << ")openapi\";\n}\n\n"
            << "}  // namespace lodestream::proto\n";
        if (out.flush()) return 0;
        std::cerr << "embed_openapi: cannot write " << argv[2] << '\n';
    } catch (const std::exception& e) {
        std::cerr << "embed_openapi: " << argv[1] << ": " << e.what() << '\n';
    }
    return 1;
}
