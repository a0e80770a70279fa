#pragma once

namespace lodestream::report {

// The commit that this program was built from, "-dirty" where files differed from it; "unknown" outside a repository.
const char* built_commit();

}  // namespace lodestream::report
