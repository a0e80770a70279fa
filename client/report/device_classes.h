// The papers' four device classes (seeds-digest §1, Table 1) as plan requests without their asset. Their one source is
// deploy/devices/*.json, which the build copies into the program.
#pragma once

#include <string>
#include <vector>

#include "proto/messages.h"

namespace lodestream::report {

struct DeviceClass {
    std::string name;
    proto::PlanRequest request;  // `asset` is empty
};

// desktop, laptop, pda, phone. Errors: those of parse_device_file, with the file's name.
Result<std::vector<DeviceClass>> device_classes();

}  // namespace lodestream::report
