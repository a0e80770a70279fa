#include "proto/openapi.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "proto/messages.h"

namespace lodestream::proto {
namespace {

using nlohmann::json;

void for_each_reference(const json& node, const std::function<void(const std::string&)>& visit) {
    if (node.is_object() && node.contains("$ref")) visit(node["$ref"].get<std::string>());
    if (node.is_structured())
        for (const json& child : node) for_each_reference(child, visit);
}

// The part of JSON Schema that the document uses, so that the examples are held against it.
void expect_valid(const json& document, const json& schema, const json& value, const std::string& where) {
    if (schema.contains("$ref")) {
        const std::string target = schema["$ref"].get<std::string>().substr(1);
        return expect_valid(document, document.at(json::json_pointer(target)), value, where);
    }
    if (schema.contains("enum")) {
        EXPECT_NE(std::find(schema["enum"].begin(), schema["enum"].end(), value), schema["enum"].end()) << where;
    }
    if (schema.contains("type")) {
        const json types = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
        const bool fits = std::any_of(types.begin(), types.end(), [&](const json& type) {
            return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
                   (type == "string" && value.is_string()) || (type == "number" && value.is_number()) ||
                   (type == "integer" && value.is_number_integer()) || (type == "boolean" && value.is_boolean()) ||
                   (type == "null" && value.is_null());
        });
        EXPECT_TRUE(fits) << where << " is " << value;
    }
    if (schema.contains("items"))
        for (const json& item : value) expect_valid(document, schema["items"], item, where + "[]");
    if (!value.is_object() || !schema.contains("properties")) return;
    for (const json& name : schema.value("required", json::array()))
        EXPECT_TRUE(value.contains(name)) << where << '.' << name;
    for (const auto& [name, member] : value.items()) {
        ASSERT_TRUE(schema["properties"].contains(name)) << where << '.' << name << " is not in the schema";
        expect_valid(document, schema["properties"][name], member, where + "." + name);
    }
}

TEST(OpenApi, IsJsonWithTypesKept) {
    const json document = json::parse(openapi_json());
    EXPECT_EQ(document["openapi"], "3.1.0");
    EXPECT_TRUE(document["info"]["version"].is_string());
    EXPECT_TRUE(document["paths"]["/livez"]["get"]["responses"].contains("200"));
    EXPECT_TRUE(document["components"]["schemas"]["Device"]["properties"]["cpu_cores"]["default"].is_number_integer());
    EXPECT_EQ(document["components"]["schemas"]["Device"]["properties"]["memory_mb"]["type"][1], "null");
    EXPECT_TRUE(document["paths"]["/v1/assets"]["post"]["parameters"][0]["required"].is_boolean());
}

TEST(OpenApi, HasEveryCall) {
    const json paths = json::parse(openapi_json())["paths"];
    for (const char* call :
         {"/livez get", "/readyz get", "/metrics get", "/ get", "/openapi.json get", "/v1/assets get",
          "/v1/assets post", "/v1/assets/{id} get", "/v1/assets/{id} delete", "/v1/assets/{id}/tileset.json get",
          "/v1/assets/{id}/nodes get", "/v1/assets/{id}/nodes patch", "/v1/plans post", "/v1/content/{hash}.glb get",
          "/v1/content/{hash}.glb head"}) {
        const std::string text = call;
        const auto space = text.find(' ');
        ASSERT_TRUE(paths.contains(text.substr(0, space))) << call;
        EXPECT_TRUE(paths[text.substr(0, space)].contains(text.substr(space + 1))) << call;
    }
}

TEST(OpenApi, HasNoDanglingReference) {
    const json document = json::parse(openapi_json());
    for_each_reference(document, [&](const std::string& reference) {
        ASSERT_EQ(reference.substr(0, 2), "#/");
        EXPECT_TRUE(document.contains(json::json_pointer(reference.substr(1)))) << reference;
    });
}

TEST(OpenApi, ExamplesFitTheSchemas) {
    const json document = json::parse(openapi_json());
    for (const char* name :
         {"Asset", "AssetList", "NodeChanges", "NodesChanged", "SceneNodes", "PlanRequest", "PlanResponse", "Problem"})
        expect_valid(document, {{"$ref", std::string("#/components/schemas/") + name}},
                     document["components"]["examples"][name]["value"], name);
}

TEST(OpenApi, WhatIsPrintedFitsTheSchemas) {
    const json document = json::parse(openapi_json());
    const auto check = [&](const char* name, const std::string& text) {
        expect_valid(document, {{"$ref", std::string("#/components/schemas/") + name}}, json::parse(text), name);
    };
    PlanResponse response;
    response.budget.limited_by = "asset";
    response.shading.mode = "flat";
    check("PlanResponse", to_json(response));
    Asset asset;
    asset.kind = "scene";
    asset.levels.resize(2);
    check("Asset", to_json(asset));
    PlanRequest request;
    request.asset = "teapot";
    check("PlanRequest", to_json(request));
    check("Problem", to_json(problem_of(fail(ErrorCode::io, "disk full"))));
}

}  // namespace
}  // namespace lodestream::proto
