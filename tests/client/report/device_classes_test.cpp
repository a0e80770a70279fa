#include "client/report/device_classes.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace lodestream::report {
namespace {

TEST(DeviceClasses, AreThePapersTableOne) {
    const auto devices = device_classes();
    ASSERT_TRUE(devices.ok()) << devices.error().message;
    ASSERT_EQ(devices->size(), 4u);
    const char* names[] = {"desktop", "laptop", "pda", "phone"};
    const double level_ratios[] = {1.0, 0.518, 0.088, 0.0206};
    for (std::size_t i = 0; i < 4; ++i) {
        const DeviceClass& device = (*devices)[i];
        EXPECT_EQ(device.name, names[i]);
        EXPECT_EQ(device.request.budget.device.name, names[i]);
        const double capacity = budget::capacity_mhz(device.request.budget.device);
        EXPECT_NEAR(capacity / budget::reference_capacity_mhz, level_ratios[i], 0.001);
        EXPECT_TRUE(budget::validate(device.request.budget).ok());
    }
}

TEST(DeviceClasses, AreTheFilesInDeploy) {
    const auto devices = device_classes();
    ASSERT_TRUE(devices.ok());
    for (const DeviceClass& device : *devices) {
        std::ifstream file(LODESTREAM_SOURCE_DIR "/deploy/devices/" + device.name + ".json");
        const std::string json{std::istreambuf_iterator<char>(file), {}};
        const auto parsed = proto::parse_device_file(json);
        ASSERT_TRUE(parsed.ok()) << device.name;
        EXPECT_EQ(proto::to_json(*parsed), proto::to_json(device.request)) << device.name;
    }
}

}  // namespace
}  // namespace lodestream::report
