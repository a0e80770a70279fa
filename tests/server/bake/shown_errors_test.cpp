#include "server/bake/shown_errors.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/bake/bake.h"
#include "server/bake/points.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace lodestream::bake {
namespace {

struct ShownErrorsTest : ::testing::Test {
    testing::TemporaryFolder folder;
    store::Store store = *store::Store::open(folder.path());

    void put(mesh::Mesh mesh, mesh::Kind kind = mesh::Kind::mesh) {
        mesh::Model model;
        model.kind = kind;
        model.mesh = std::move(mesh);
        model.materials.resize(1);
        proto::Asset asset;
        asset.id = asset.name = "model";
        const auto done = bake(store, asset, std::move(model));
        ASSERT_TRUE(done) << done.error().message;
    }
};

TEST_F(ShownErrorsTest, ABakeMeasuresBothDownToOne) {
    put(testing::sphere(40));  // 3,120 triangles
    const auto errors = load_shown_errors(store, "model");
    ASSERT_TRUE(errors) << errors.error().message;
    for (const auto* list : {&errors->gouraud, &errors->flat, &errors->points}) {
        ASSERT_EQ(list->size(), 13u);  // 1, 2, 4, ... 2,048 and all
        EXPECT_EQ(list->front().count, 1u);
        EXPECT_EQ(list->back().count, 3120u);
        EXPECT_GT(error_at(*list, 8), 2.0 * error_at(*list, 1000));
    }
    EXPECT_EQ(error_at(errors->gouraud, 3120), 0.0);
    EXPECT_GT(error_at(errors->flat, 3120), 0.0);
    EXPECT_GT(error_at(errors->points, 3120), error_at(errors->gouraud, 1000));
}

TEST_F(ShownErrorsTest, ACloudHasNoneForItHasNoTriangles) {
    mesh::Mesh cloud = testing::sphere(20);
    cloud.triangles.clear();
    put(std::move(cloud), mesh::Kind::points);
    const auto errors = load_shown_errors(store, "model");
    ASSERT_FALSE(errors);
    EXPECT_EQ(errors.error().code, ErrorCode::not_found);
}

TEST_F(ShownErrorsTest, DamageIsToldApartFromWhatWasMeasured) {
    put(testing::sphere(12));
    const ShownErrors sound{{{1, 0.5}, {4, 0.25}}, {{1, 0.5}}, {}};
    ASSERT_TRUE(put_shown_errors(store, "model", sound));
    EXPECT_EQ(load_shown_errors(store, "model")->gouraud[1].error, 0.25);
    for (const ShownErrors& damaged : {ShownErrors{{{4, 0.5}, {1, 0.25}}, {}, {}}, ShownErrors{{}, {{1, -1.0}}, {}},
                                       ShownErrors{{}, {}, {{1, std::nan("")}}}}) {
        ASSERT_TRUE(put_shown_errors(store, "model", damaged));
        const auto read = load_shown_errors(store, "model");
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().code, ErrorCode::invalid_input);
    }
    const std::array<std::byte, 20> bytes{};
    ASSERT_TRUE(store.put_content("model", shown_errors_key, "shown", bytes));
    EXPECT_FALSE(load_shown_errors(store, "model"));
}

TEST(ErrorAt, LiesBetweenThoseMeasuredByTheirLogarithms) {
    const std::vector<ShownError> errors{{1, 0.8}, {4, 0.2}, {100, 0.0}};
    EXPECT_EQ(error_at(errors, 0), 0.8);
    EXPECT_EQ(error_at(errors, 1), 0.8);
    EXPECT_NEAR(error_at(errors, 2), 0.4, 1e-12);
    EXPECT_EQ(error_at(errors, 99), 0.2);  // nothing tells where between it ends
    EXPECT_EQ(error_at(errors, 100), 0.0);
    EXPECT_EQ(error_at(errors, 1000), 0.0);
    EXPECT_EQ(error_at({}, 5), 0.0);
}

}  // namespace
}  // namespace lodestream::bake
