#include "proto/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "proto/nodes.h"

namespace lodestream::proto {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string example(const std::string& name) {
    std::ifstream file(std::string(LODESTREAM_SOURCE_DIR) + "/proto/examples/" + name + ".json");
    EXPECT_TRUE(file) << name;
    return {std::istreambuf_iterator<char>(file), {}};
}

// A plan request with `members` in place of its device.
std::string refusal_of(const std::string& members) {
    const auto request = parse_plan_request(R"({"asset":"teapot",)" + members + "}");
    return request ? "accepted" : request.error().message;
}
std::string device_refusal_of(const std::string& members) {
    return refusal_of(R"("device":{)" + members + "}");
}

constexpr const char* contract_request = R"({"asset":"teapot",
 "device":{"cpu_mhz":300,"cpu_cores":1,"gpu":"none","memory_mb":64,"triangles_per_second":null},
 "display":{"width":800,"height":600},
 "preference":{"triangles":null,"quality":1.0,"target_fps":30},
 "network":{"downlink_mbps":2,"rtt_ms":80,"max_wait_s":3},
 "reference":{"capacity_mhz":3400,"triangles":6400},
 "view":{"eye":[0,0,5],"target":[0,0,0],"fov_y_deg":45,"light":[0.3,1,0.5]}})";

TEST(PlanRequest, ReadsTheContractsExample) {
    const auto request = parse_plan_request(contract_request);
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->asset, "teapot");
    EXPECT_EQ(request->budget.device.cpu_mhz, 300.0);
    EXPECT_EQ(request->budget.device.gpu, budget::Gpu::none);
    EXPECT_EQ(request->budget.device.memory_mb, 64.0);
    EXPECT_FALSE(request->budget.device.triangles_per_second);
    EXPECT_EQ(request->budget.display->width, 800u);
    EXPECT_FALSE(request->budget.preference.triangles);
    EXPECT_EQ(request->budget.network->rtt_ms, 80.0);
    EXPECT_EQ(request->budget.reference.triangles, 6400u);
    EXPECT_EQ(request->view->eye, Vec3d(0, 0, 5));
    EXPECT_EQ(request->profile, Profile::plain);
    EXPECT_EQ(request->shading, ShadingMode::hybrid);
}

TEST(PlanRequest, NeedsOnlyAssetAndDevice) {
    const auto request = parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":70}})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_FALSE(request->budget.display);
    EXPECT_FALSE(request->budget.network);
    EXPECT_FALSE(request->view);
    EXPECT_EQ(request->budget.reference.capacity_mhz, budget::reference_capacity_mhz);
    EXPECT_EQ(parse_plan_request(R"({"device":{"cpu_mhz":70}})").error().message, "asset is missing");
    EXPECT_EQ(refusal_of(R"("display":null)"), "device is missing");
    EXPECT_EQ(device_refusal_of(R"("gpu":"none")"), "device.cpu_mhz is missing");
}

TEST(PlanRequest, TakesNullAsAbsentEverywhere) {
    const auto request = parse_plan_request(
        R"({"asset":"a","device":{"cpu_mhz":70,"gpu":null,"cpu_cores":null,"name":null},"display":null,"network":null,
            "preference":null,"reference":{"capacity_mhz":null,"triangles":null},"view":null,"profile":null,"shading":null})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->budget.device.cpu_cores, 1u);
}

TEST(PlanRequest, IgnoresUnknownMembers) {
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":70,"flux_capacitor":{"on":[true]})"), "accepted");
}

TEST(PlanRequest, NamesTheFieldOfAWrongType) {
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":"fast")"), "device.cpu_mhz must be a number, got \"fast\"");
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":70,"gpu":"huge")"),
              "device.gpu must be one of \"none\", \"discrete\", got \"huge\"");
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":70,"gpu":1)"), "device.gpu must be a string, got 1");
    EXPECT_EQ(refusal_of(R"("device":[])"), "device must be an object, got []");
    EXPECT_EQ(refusal_of(R"("device":{"cpu_mhz":1},"display":{"width":1.5,"height":1})"),
              "display.width must be a whole number from 0 to 4294967295, got 1.5");
    EXPECT_EQ(refusal_of(R"("device":{"cpu_mhz":1},"preference":{"triangles":-1})"),
              "preference.triangles must be a whole number from 0 to 9007199254740992, got -1");
    EXPECT_EQ(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[1,2]})"),
              "view.eye must be an array of 3 numbers, got [1,2]");
    EXPECT_EQ(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[1,2,"x"]})"),
              "view.eye must be an array of 3 numbers, got [1,2,\"x\"]");
    EXPECT_EQ(parse_plan_request("[]").error().message, "the body must be an object, got []");
}

TEST(PlanRequest, NamesTheFieldOutOfRange) {
    EXPECT_THAT(device_refusal_of(R"("cpu_mhz":-3)"), AllOf(StartsWith("device.cpu_mhz"), HasSubstr("-3")));
    EXPECT_THAT(device_refusal_of(R"("cpu_mhz":0)"), StartsWith("device.cpu_mhz"));
    EXPECT_THAT(refusal_of(R"("device":{"cpu_mhz":1},"network":{"downlink_mbps":0})"),
                StartsWith("network.downlink_mbps"));
    EXPECT_THAT(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[0,0,5],"light":[0,0,0]})"), HasSubstr("light"));
    EXPECT_THAT(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[0,0,0]})"), HasSubstr("eye"));
}

TEST(PlanRequest, RefusesNumbersThatAreNotFinite) {
    EXPECT_THAT(device_refusal_of(R"("cpu_mhz":1e999)"), StartsWith("device.cpu_mhz must be a finite number"));
    EXPECT_THAT(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[0,-1e999,0]})"),
                StartsWith("view.eye must be a finite number"));
    EXPECT_THAT(device_refusal_of(R"("cpu_mhz":NaN)"), StartsWith("not valid JSON"));
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":1e300)"), "accepted");
}

TEST(PlanRequest, RefusesAMemberGivenTwice) {
    EXPECT_EQ(device_refusal_of(R"("cpu_mhz":1,"cpu_mhz":2)"), "not valid JSON: device.cpu_mhz is given twice");
    EXPECT_EQ(refusal_of(R"("device":{"cpu_mhz":1},"view":{"eye":[0,0,5]},"x":[{"a":1},{"a":2}])"), "accepted");
}

TEST(PlanRequest, RefusesWhatIsNotJson) {
    for (const char* text : {"", "{", "nonsense", "{\"asset\":\"a\",}", "{} {}", "\xff\xfe", "{\"a\":\"\xc3\x28\"}"})
        EXPECT_THAT(parse_plan_request(text).error().message, StartsWith("not valid JSON")) << text;
}

TEST(PlanRequest, RefusesDeepNestingWithoutRecursion) {
    const std::string deep = R"({"asset":"a","x":)" + std::string(1'000'000, '[');
    EXPECT_EQ(parse_plan_request(deep).error().message, "not valid JSON: deeper than 32 levels");
    const std::string just = R"("device":{"cpu_mhz":1},"x":)" + std::string(31, '[') + std::string(31, ']');
    EXPECT_EQ(refusal_of(just), "accepted");
}

TEST(PlanRequest, QuotesLongValuesShortAndAsUtf8) {
    std::string emoji;
    for (int i = 0; i < 1000; ++i) emoji += "\xf0\x9f\xab\x96";
    const std::string message = device_refusal_of("\"cpu_mhz\":\"" + emoji + "\"");
    EXPECT_LT(message.size(), 120u);
    EXPECT_NO_THROW(nlohmann::json(message).dump());
}

TEST(DeviceFile, MayBeARequestWithoutAnAssetOrABareReport) {
    const auto whole = parse_device_file(R"({"device":{"cpu_mhz":300},"display":{"width":320,"height":240}})");
    ASSERT_TRUE(whole) << whole.error().message;
    EXPECT_EQ(whole->budget.display->width, 320u);
    const auto bare = parse_device_file(R"({"name":"pda","cpu_mhz":300,"gpu":"none"})");
    ASSERT_TRUE(bare) << bare.error().message;
    EXPECT_EQ(bare->budget.device.name, "pda");
    EXPECT_THAT(parse_device_file(R"({"cpu_mhz":0})").error().message, StartsWith("device.cpu_mhz"));
    EXPECT_EQ(parse_device_file("3").error().message, "the body must be an object, got 3");
}

// Golden examples: what is printed is what is documented.
template <class Parse>
void expect_round_trip(const std::string& name, Parse parse) {
    const std::string text = example(name);
    const auto message = parse(text);
    ASSERT_TRUE(message) << message.error().message;
    EXPECT_EQ(nlohmann::ordered_json::parse(to_json(*message)).dump(2), nlohmann::ordered_json::parse(text).dump(2));
}

TEST(Examples, RoundTrip) {
    expect_round_trip("node_changes", parse_node_changes);
    expect_round_trip("nodes_changed", parse_nodes_changed);
    expect_round_trip("scene_nodes", parse_scene_nodes);
    expect_round_trip("plan_request", parse_plan_request);
    expect_round_trip("plan_response", parse_plan_response);
    expect_round_trip("asset", parse_asset);
    expect_round_trip("assets", parse_assets);
    expect_round_trip("problem", parse_problem);
}

TEST(PlanResponse, ReadsTheContractsExample) {
    const auto response = parse_plan_response(R"({"dlr":0.0882,"ncp":564,"rup":null,
 "budget":{"triangles":564,"limited_by":"device"},
 "level":{"triangles":564,"vertices":298,"rms_error":0.0,"max_error":0.0,"screen_space_error_px":0.0},
 "shading":{"distance":0.4,"gouraud":338,"flat":226,"operations":{"criterion":0,"total":0}},
 "content":{"url":"/v1/content/….glb","bytes":0,"media_type":"model/gltf-binary","profile":"plain"},
 "left_out":[{"what":"normals of flat triangles","bytes":0}],
 "timing_ms":{"plan":0.0,"cut":0.0,"encode":0.0}})");
    ASSERT_TRUE(response) << response.error().message;
    EXPECT_EQ(response->ncp, 564u);
    EXPECT_FALSE(response->rup);
    EXPECT_EQ(response->shading.gouraud + response->shading.flat, response->level.triangles);
    ASSERT_EQ(response->left_out.size(), 1u);
}

TEST(PlanResponse, PrintsEveryNameOfTheContract) {
    const auto json = nlohmann::json::parse(to_json(PlanResponse{}));
    for (const char* pointer : {"/dlr",
                                "/ncp",
                                "/rup",
                                "/budget/triangles",
                                "/budget/limited_by",
                                "/level/triangles",
                                "/level/vertices",
                                "/level/rms_error",
                                "/level/max_error",
                                "/level/screen_space_error_px",
                                "/shading/distance",
                                "/shading/gouraud",
                                "/shading/flat",
                                "/shading/operations/criterion",
                                "/shading/operations/total",
                                "/content/url",
                                "/content/bytes",
                                "/content/media_type",
                                "/content/profile",
                                "/left_out",
                                "/timing_ms/plan",
                                "/timing_ms/cut",
                                "/timing_ms/encode"})
        EXPECT_TRUE(json.contains(nlohmann::json::json_pointer(pointer))) << pointer;
    EXPECT_TRUE(json["rup"].is_null());
    EXPECT_TRUE(json["left_out"].is_array());
}

TEST(PlanResponse, TellsOfPointsWhereThereAreAny) {
    PlanResponse response;
    EXPECT_EQ(to_json(response).find("points"), std::string::npos);
    response.budget.points = 900;
    response.level.points = 800;
    response.crossing = {12.0, 0.25, 3.5};
    const auto again = parse_plan_response(to_json(response));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->budget.points, 900u);
    EXPECT_EQ(again->level.points, 800u);
    ASSERT_TRUE(again->crossing);
    EXPECT_EQ(again->crossing->distance, 12.0);
    EXPECT_EQ(again->crossing->triangles_error_percent, 0.25);
    EXPECT_EQ(again->crossing->points_error_percent, 3.5);
}

TEST(PlanResponse, TellsTheErrorOfAnOutsideWhereALevelShowsNothingElse) {
    PlanResponse response;
    EXPECT_EQ(to_json(response).find("outside"), std::string::npos);
    response.level.outside = {0.5, 1.5};
    const auto again = parse_plan_response(to_json(response));
    ASSERT_TRUE(again) << again.error().message;
    ASSERT_TRUE(again->level.outside);
    EXPECT_EQ(again->level.outside->rms_error, 0.5);
    EXPECT_EQ(again->level.outside->max_error, 1.5);
}

TEST(PlanRequest, TellsWhatFlatTrianglesCostTheDevice) {
    const auto request =
        parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":300,"flat_triangles_per_second":5e5}})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->budget.device.flat_triangles_per_second, 5e5);
    EXPECT_FALSE(budget::gouraud_costs_no_more(request->budget.device));  // nothing to compare it with
    EXPECT_FALSE(parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":300,"flat_triangles_per_second":-1}})"));
}

TEST(PlanRequest, NamesWhatALevelMayBeMadeOf) {
    const auto request =
        parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":300,"points_per_second":5e5},"primitives":"any"})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->primitives, Primitives::any);
    EXPECT_EQ(request->budget.device.points_per_second, 5e5);
    EXPECT_FALSE(parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":300},"primitives":"voxels"})"));
    EXPECT_FALSE(parse_plan_request(R"({"asset":"a","device":{"cpu_mhz":300,"points_per_second":0}})"));
    for (const Primitives primitives : {Primitives::triangles, Primitives::points, Primitives::any})
        EXPECT_EQ(parse_primitives(primitives_name(primitives)).value(), primitives);
    EXPECT_FALSE(parse_primitives("Points"));
}

TEST(PlanResponse, NamesWhatIsMissing) {
    EXPECT_EQ(parse_plan_response(R"({"dlr":1,"ncp":1})").error().message, "budget is missing");
    EXPECT_EQ(parse_assets("{}").error().message, "assets is missing");
    EXPECT_EQ(parse_assets(R"({"assets":[{"id":"a","name":"a","kind":"mesh","triangles":1,"vertices":3,"status":"ready",
                              "levels":[{"triangles":"x"}]}]})")
                  .error()
                  .message,
              "assets[0].levels[0].triangles must be a whole number, got \"x\"");
}

TEST(Json, StaysValidWhateverTheText) {
    Asset asset;
    asset.name = "caf\xe9 \"\\\n";
    EXPECT_TRUE(nlohmann::json::accept(to_json(asset)));
    EXPECT_TRUE(nlohmann::json::accept(to_json(Problem{500, "\xff", "\xc3", "about:blank"})));
}

TEST(Problem, GivesEachErrorItsStatus) {
    const auto status = [](ErrorCode code) { return problem_of(fail(code, "why")).status; };
    EXPECT_EQ(status(ErrorCode::invalid_input), 422);
    EXPECT_EQ(status(ErrorCode::unsupported), 415);
    EXPECT_EQ(status(ErrorCode::limit_exceeded), 413);
    EXPECT_EQ(status(ErrorCode::not_found), 404);
    EXPECT_EQ(status(ErrorCode::conflict), 409);
    EXPECT_EQ(status(ErrorCode::unauthorized), 401);
    EXPECT_EQ(status(ErrorCode::unavailable), 503);
    EXPECT_EQ(status(ErrorCode::io), 500);
    EXPECT_EQ(status(ErrorCode::internal), 500);
    EXPECT_EQ(problem_of(invalid_input("why")).detail, "why");
}

TEST(Names, ShadingModesReadBack) {
    for (const ShadingMode mode : {ShadingMode::hybrid, ShadingMode::gouraud, ShadingMode::flat})
        EXPECT_EQ(parse_shading_mode(shading_mode_name(mode)).value(), mode);
    EXPECT_FALSE(parse_shading_mode("Phong"));
}

}  // namespace
}  // namespace lodestream::proto
