// libFuzzer over the JSON messages: what is read is written and read again to the same text. See run.sh.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "proto/gzip.h"
#include "proto/messages.h"
#include "proto/tileset.h"

namespace {

using namespace lodestream;

void require(bool holds) {
    if (!holds) std::abort();
}

// Whatever `parse` takes comes out of `to_json` as it went in.
template <class Parse>
void check(std::string_view text, const Parse& parse) {
    const auto message = parse(text);
    if (!message) return;
    const std::string written = proto::to_json(*message);
    const auto again = parse(written);
    require(again.ok());
    require(proto::to_json(*again) == written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    check(text, [](std::string_view t) { return proto::parse_plan_request(t); });
    check(text, [](std::string_view t) { return proto::parse_plan_response(t); });
    check(text, [](std::string_view t) { return proto::parse_asset(t); });
    check(text, [](std::string_view t) { return proto::parse_problem(t); });
    (void)proto::parse_device_file(text);
    (void)proto::parse_assets(text);
    if (auto tileset = proto::parse_tileset(text))
        if (const auto document = proto::parse_document(text, tileset->matrix(0)))
            (void)proto::add_document(*tileset, static_cast<std::uint32_t>(tileset->nodes.size() - 1), *document);
    (void)proto::accepts_gzip(text);
    (void)proto::gunzip(text, 1 << 20);
    return 0;
}
