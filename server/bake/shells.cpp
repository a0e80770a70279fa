// The stored form of a shell: magic "LODSHEL1", its errors, the triangles that colour it, and a baked model as an array
// of bytes; as stored_form.h says.
#include "server/bake/shells.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string_view>
#include <utility>

#include "server/bake/executor.h"
#include "server/bake/seen_surface.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODSHEL1";
// Shares of its progress.
constexpr double recorded_share = 0.2;
constexpr double chosen_share = 0.6;
// What is hidden is far from every level: fewer samples tell as much of it.
constexpr std::size_t whole_samples = 20'000;

// A history that may serve from some count on, measured from there.
struct Candidate {
    const simplify::History* history;
    std::vector<ErrorSample> errors;
};

// Below half of the scene's triangles: above, there is nothing to be won.
std::uint64_t finest_count(const mesh::Mesh& scene) {
    return std::clamp<std::uint64_t>(scene.triangles.size() / 2, 1, shell_triangles);
}

// Goes down in triangles and hands over to the candidate that shows a count best; one that was left is not measured
// any more. The scene's own history is the one in charge at first. Tells `progress` what is left in halvings; false
// where it was cancelled.
bool hand_over(const simplify::History& scene, std::vector<Candidate>& shells, const SeenSurface& seen,
               const mesh::Mesh& seen_finest, std::uint64_t most, const std::function<bool(double)>& progress) {
    Candidate own{&scene, {}};
    Candidate* in_charge = &own;
    for (std::uint64_t count = most; count > 0; count /= 2) {
        if (!progress(1.0 - std::log2(1.0 + static_cast<double>(count)) / std::log2(1.0 + static_cast<double>(most))))
            return false;
        std::vector<Candidate*> measured{in_charge};
        for (Candidate& shell : shells)
            if (&shell != in_charge && shell.errors.empty()) measured.push_back(&shell);
        std::vector<metric::SurfaceError> errors(measured.size());
        all_cores()(measured.size(), [&](std::size_t i) {
            errors[i] = metric::measure(seen.original, seen_finest, simplify::cut(*measured[i]->history, count));
        });
        std::size_t best = 0;
        for (std::size_t i = 1; i < errors.size(); ++i)
            if (errors[i].rms < errors[best].rms) best = i;
        in_charge->errors.push_back({count, errors[0]});  // where it hands over, too: it serves down to here
        if (best == 0) continue;
        in_charge = measured[best];
        in_charge->errors.push_back({count, errors[best]});
    }
    return true;
}

// What is hidden is far from every level and hardly farther from a coarser one: fewer counts tell enough of it.
std::vector<ErrorSample> every_second(const std::vector<ErrorSample>& samples) {
    std::vector<ErrorSample> some;
    for (std::size_t i = 0; i < samples.size(); i += 2) some.push_back(samples[i]);
    if (samples.size() % 2 == 0) some.push_back(samples.back());
    return some;
}

// At the same counts; fewer where it was cancelled.
std::vector<ErrorSample> measured(const simplify::History& history, const std::vector<ErrorSample>& counts,
                                  const mesh::Mesh& finest, const metric::SurfaceIndex& original,
                                  const std::function<bool(double)>& progress) {
    std::vector<ErrorSample> errors(counts.size());
    std::atomic<std::size_t> done{0};
    std::atomic<bool> going{true};
    all_cores()(counts.size(), [&](std::size_t i) {
        if (!going) return;
        errors[i] = {counts[i].triangles,
                     metric::measure(original, finest, simplify::cut(history, counts[i].triangles))};
        if (!progress(static_cast<double>(++done) / static_cast<double>(counts.size()))) going = false;
    });
    return errors;
}

// A coarser level is never said to be better than a finer one of the scene's own.
std::vector<ErrorSample> below(const std::vector<ErrorSample>& scene, std::vector<ErrorSample> errors) {
    const std::uint64_t most = errors.front().triangles;
    std::vector<ErrorSample> all = std::move(errors);
    for (const ErrorSample& sample : scene)
        if (sample.triangles > most) all.push_back(sample);
    all = in_order(std::move(all));
    all.erase(all.begin(), std::find_if(all.begin(), all.end(),
                                        [&](const ErrorSample& sample) { return sample.triangles <= most; }));
    return all;
}

BakedModel baked_shell(const BakedModel& scene, bool is_bare, simplify::History history) {
    BakedModel shell;
    shell.bounds = scene.bounds;
    shell.model = scene.model;
    if (is_bare) {
        shell.model.materials.assign(1, {});
        shell.model.images.clear();
    } else {
        shell.image_uses = scene.image_uses;
        shell.texel_sizes = scene.texel_sizes;
    }
    set_history(shell, std::move(history));
    return shell;
}

}  // namespace

Result<std::vector<Shell>> make_shells(const BakedModel& scene, const mesh::Mesh& finest,
                                       const std::function<bool(double)>& progress) {
    const Error ended = fail(ErrorCode::unavailable, "the bake was ended");
    const std::uint64_t most = finest_count(finest);
    SeenSurface seen = seen_from_outside({finest, false}, most, can_be_painted(scene.model.materials));
    const mesh::Mesh seen_finest = seen.surfaces.front().mesh;
    std::vector<simplify::History> histories;
    for (Surface& surface : seen.surfaces) {
        const auto done = static_cast<double>(histories.size());
        const auto all = static_cast<double>(seen.surfaces.size());
        simplify::RecordOptions recording;
        recording.executor = all_cores();
        recording.progress = [&](double share) { return progress(recorded_share * (done + share) / all); };
        Result<simplify::History> history = simplify::record_history(std::move(surface.mesh), recording);
        if (!history) return history.error();
        histories.push_back(*std::move(history));
    }
    std::vector<Candidate> candidates;
    for (const simplify::History& history : histories) candidates.push_back({&history, {}});
    const auto handing = [&](double share) { return progress(std::lerp(recorded_share, chosen_share, share)); };
    if (!hand_over(scene.history, candidates, seen, seen_finest, most, handing)) return ended;
    const metric::SurfaceIndex original(finest, whole_samples);
    const auto measuring = [&](double share) { return progress(std::lerp(chosen_share, 1.0, share)); };

    std::vector<Shell> shells;
    for (std::size_t i = 0; i < histories.size(); ++i) {
        std::vector<ErrorSample>& seen_errors = candidates[i].errors;
        if (seen_errors.empty()) continue;
        std::vector<ErrorSample> errors =
            measured(histories[i], every_second(seen_errors), finest, original, measuring);
        if (!progress(chosen_share)) return ended;
        Shell& shell = shells.emplace_back();
        shell.baked = baked_shell(scene, seen.surfaces[i].is_bare, std::move(histories[i]));
        shell.baked.errors = below(scene.errors, std::move(errors));
        shell.seen_errors = in_order(std::move(seen_errors));
        if (seen.surfaces[i].is_bare) shell.colored_by = seen.triangles;
    }
    std::sort(shells.begin(), shells.end(), [](const Shell& a, const Shell& b) {
        return a.seen_errors.front().triangles < b.seen_errors.front().triangles;
    });
    return shells;
}

std::vector<std::byte> serialize(const Shell& shell) {
    Writer writer;
    writer.magic(magic);
    writer(shell.seen_errors);
    writer(shell.colored_by);
    const std::vector<std::byte> baked = serialize(shell.baked);
    writer.array(baked);
    return std::move(writer.bytes);
}

Result<ShellView> open_shell(std::span<const std::byte> bytes) {
    const auto damaged = [](const std::string& what) { return invalid_input("a stored shell is damaged: " + what); };
    Reader reader(bytes);
    if (!reader.magic(magic)) return damaged("it does not start with LODSHEL1");
    ShellView shell;
    std::span<const std::byte> baked_bytes;
    reader(shell.seen_errors);
    reader(shell.colored_by);
    reader.array(baked_bytes);
    if (!reader.ok() || !reader.at_end()) return damaged("it ends too early or too late");
    if (Status valid = validate_errors(shell.seen_errors); !valid) return damaged(valid.error().message);
    Result<BakedView> baked = open_baked_model(baked_bytes);
    if (!baked) return baked.error();
    shell.baked = *std::move(baked);
    return shell;
}

Status put_shells(store::Store& store, const std::string& asset_id, const std::vector<Shell>& shells) {
    for (std::size_t i = 0; i < shells.size(); ++i)
        if (auto file = store.put_content(asset_id, shell_key(i), "bake", serialize(shells[i])); !file)
            return file.error();
    return Nothing{};
}

}  // namespace lodestream::bake
