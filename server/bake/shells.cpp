// The stored form of a shell: magic "LODSHEL2" (or "LODSHEL1", with older errors), its errors, the triangles that
// colour it, and a baked model as an array of bytes; as stored_form.h says.
#include "server/bake/shells.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "server/bake/executor.h"
#include "server/bake/seen_surface.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODSHEL2", older_magic = "LODSHEL1";
// Shares of its progress.
constexpr double recorded_share = 0.2;
constexpr double chosen_share = 0.6;
constexpr double halvings_share = 0.8;  // of choosing
// What is hidden is far from every level: fewer samples tell as much of it.
constexpr std::size_t whole_samples = 20'000;
// Of the finest level of the surface wrapped around a scene: an image over a finer one costs more than it shows.
constexpr std::uint64_t wrapped_triangles = 30'720;
constexpr double negligible_error = 1e-9;  // of the scene's diagonal

// Runs task(0) … task(count - 1) on all cores. Returns false where `progress` ended it.
bool run_reporting(std::size_t count, const std::function<bool(double)>& progress,
                   const std::function<void(std::size_t)>& task) {
    std::atomic<std::size_t> done{0};
    std::atomic<bool> going{true};
    all_cores()(count, [&](std::size_t i) {
        if (!going) return;
        task(i);
        if (!progress(static_cast<double>(++done) / static_cast<double>(count))) going = false;
    });
    return going;
}

// A history that levels of up to so many triangles may be cut from.
struct Candidate {
    const simplify::History* history;
    std::uint64_t most;
    std::map<std::uint64_t, metric::SurfaceError> errors;  // at the counts that were measured
};

// Halvings: from the most triangles that any shell may serve down to one.
std::vector<std::uint64_t> counts_from(std::uint64_t most) {
    std::vector<std::uint64_t> counts;
    for (std::uint64_t count = most; count > 0; count /= 2) counts.push_back(count);
    return counts;
}

// Who serves which counts: the scene's own history from the finest on, then one candidate, then the other; each may
// serve none. Ends are indices of counts.
struct Rule {
    std::array<std::size_t, 3> order{};
    std::array<std::size_t, 3> ends{};
};

// The counts with some more around those at which a rule hands over.
std::vector<std::uint64_t> refined(const std::vector<std::uint64_t>& counts, const Rule& rule) {
    std::vector<std::uint64_t> all = counts;
    for (const std::size_t end : {rule.ends[0], rule.ends[1]}) {
        if (end == 0 || end == counts.size()) continue;
        for (const double power : {0.25, 0.5, 0.75})
            all.push_back(static_cast<std::uint64_t>(static_cast<double>(counts[end]) * std::exp2(power)));
    }
    std::sort(all.begin(), all.end(), std::greater<>());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

// Against what is seen, at the counts that have not been measured yet. Returns false where it was cancelled.
bool measure_all(std::vector<Candidate>& candidates, const std::vector<std::uint64_t>& counts, const SeenSurface& seen,
                 const mesh::Mesh& seen_finest, const std::function<bool(double)>& progress) {
    struct Task {
        const simplify::History* history;
        std::uint64_t count;
        metric::SurfaceError* error;
    };
    std::vector<Task> tasks;
    for (const std::uint64_t count : counts)
        for (Candidate& candidate : candidates) {
            if (count > candidate.most) continue;
            const auto [place, is_new] = candidate.errors.try_emplace(count);
            if (is_new) tasks.push_back({candidate.history, count, &place->second});
        }
    return run_reporting(tasks.size(), progress, [&](std::size_t i) {
        const auto& [history, count, error] = tasks[i];
        *error = metric::measure(seen.original, seen_finest, simplify::cut(*history, count));
    });
}

// The rule of the least error over all counts, by its logarithm: a count more or less decides nothing. `negligible`: an
// error that need not be less.
Rule best_rule(const std::vector<Candidate>& candidates, const std::vector<std::uint64_t>& counts, double negligible) {
    const auto cost_of = [&](std::size_t who, std::size_t count) {
        if (who >= candidates.size() || counts[count] > candidates[who].most)
            return std::numeric_limits<double>::infinity();
        return std::log(candidates[who].errors.at(counts[count]).rms + negligible);
    };
    const auto cost = [&](const Rule& rule) {
        double sum = 0;
        for (std::size_t k = 0, count = 0; k < rule.order.size(); ++k)
            for (; count < rule.ends[k]; ++count) sum += cost_of(rule.order[k], count);
        return sum;
    };
    const std::size_t n = counts.size();
    Rule best{{0, 1, 2}, {n, n, n}};
    double least = cost(best);
    for (const std::array<std::size_t, 3>& order : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 1}})
        for (std::size_t first = n + 1; first-- > 0;)
            for (std::size_t second = n + 1; second-- > first;) {
                const Rule rule{order, {first, second, n}};
                if (const double sum = cost(rule); sum < least) {
                    least = sum;
                    best = rule;
                }
            }
    return best;
}

// What a candidate is off where it serves, and at the next count too: it serves down to there. Empty: it serves none.
std::vector<ErrorSample> served(const Candidate& candidate, std::size_t number, const Rule& rule,
                                const std::vector<std::uint64_t>& counts) {
    std::vector<ErrorSample> errors;
    for (std::size_t k = 1; k < rule.order.size(); ++k) {
        if (rule.order[k] != number || rule.ends[k - 1] == rule.ends[k]) continue;
        for (std::size_t i = rule.ends[k - 1]; i < std::min(rule.ends[k] + 1, counts.size()); ++i)
            errors.push_back({counts[i], candidate.errors.at(counts[i])});
    }
    return errors;
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
    run_reporting(counts.size(), progress, [&](std::size_t i) {
        errors[i] = {counts[i].triangles,
                     metric::measure(original, finest, simplify::cut(history, counts[i].triangles))};
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
    const std::uint64_t most = std::max<std::uint64_t>(1, finest.triangles.size() / 2);  // above, little can be won
    SeenSurface seen =
        seen_from_outside({finest, false}, std::min(most, wrapped_triangles), can_be_painted(scene.model.materials));
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
    std::vector<Candidate> candidates{{&scene.history, most, {}}};
    for (std::size_t i = 0; i < histories.size(); ++i)
        candidates.push_back({&histories[i], seen.surfaces[i].is_bare ? wrapped_triangles : most, {}});
    const double negligible = negligible_error * scene.bounds.diagonal();
    std::vector<std::uint64_t> counts = counts_from(most);
    const auto measuring_seen = [&](double from, double to) {
        return measure_all(candidates, counts, seen, seen_finest, [&, from, to](double share) {
            return progress(std::lerp(recorded_share, chosen_share, std::lerp(from, to, share)));
        });
    };
    if (!measuring_seen(0.0, halvings_share)) return ended;
    counts = refined(counts, best_rule(candidates, counts, negligible));
    if (!measuring_seen(halvings_share, 1.0)) return ended;
    const Rule rule = best_rule(candidates, counts, negligible);
    const metric::SurfaceIndex original(finest, whole_samples);
    const auto measuring = [&](double share) { return progress(std::lerp(chosen_share, 1.0, share)); };

    std::vector<Shell> shells;
    for (std::size_t i = 0; i < histories.size(); ++i) {
        std::vector<ErrorSample> seen_errors = served(candidates[i + 1], i + 1, rule, counts);
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
    const bool is_older = Reader(bytes).magic(older_magic);
    Reader reader(bytes);
    if (!reader.magic(magic) && !is_older) return damaged("it does not start with LODSHEL2");
    ShellView shell;
    std::span<const std::byte> baked_bytes;
    is_older ? read_older_errors(reader, shell.seen_errors) : reader(shell.seen_errors);
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
