// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/choose_conditions.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <nlopt.hpp>
#include <numbers>
#include <string_view>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
// What a limit may be exceeded by and still count as met: a thousandth is below any measurement.
constexpr double kMet = 1e-3;
constexpr std::array<const char*, kVariables> kVariableNames = {"feed_per_tooth", "spindle_speed",
                                                                "axial_depth", "radial_depth"};

/// The free variables on [0, 1], by their logarithm.
class Scale {
 public:
  explicit Scale(const std::array<Span, kVariables>& spans) : spans_(spans) {
    for (std::size_t i = 0; i < kVariables; ++i) {
      if (spans[i].high > spans[i].low * (1.0 + 1e-12)) free_.push_back(i);
    }
  }
  unsigned size() const { return static_cast<unsigned>(free_.size()); }
  Point point(const double* x) const {
    Point p{};
    for (std::size_t i = 0; i < kVariables; ++i) p[i] = spans_[i].low;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const Span& span = spans_[free_[k]];
      p[free_[k]] = span.low * std::pow(span.high / span.low, std::clamp(x[k], 0.0, 1.0));
    }
    return p;
  }

 private:
  std::array<Span, kVariables> spans_;
  std::vector<std::size_t> free_;
};

/// Spectral radius at points of a candidate's lattice that have been worked out: it knows no
/// limits, so that problems that differ by these share it.
using ChatterAt = std::map<std::size_t, double>;

/// One candidate: COBYLA on the logarithms, limits as inequality constraints.
class Search {
 public:
  Search(const ChoiceProblem& problem, const Candidate& candidate, ChatterAt& chatter)
      : problem_(problem),
        candidate_(candidate),
        chatter_(chatter),
        evaluator_(problem, candidate),
        scale_(problem.spans) {
    limits_ =
        limit_uses(problem, evaluator_(scale_.point(std::vector<double>(4, 0.5).data()))).size();
  }

  /// `solved` hears of each search that ends, and says whether to go on.
  Choice run(const std::string& name, const std::function<bool()>& solved) {
    const auto from = [&](double start) { return std::vector<double>(scale_.size(), start); };
    const auto search = [&](const std::vector<double>& start, bool restore, double step) {
      if (stopped_) return;
      solve(start, restore, step);
      stopped_ = !solved();
    };
    constexpr double wide = 0.1, fine = 0.02;
    if (problem_.limits.chatter) {
      try_lattice();
    }
    quality_at(from(0.5).data());
    if (scale_.size() > 0) {
      // Where the middle leads to nothing that meets the limits, whether anything does comes first.
      search(from(0.5), false, wide);
      if (!best_.feasible) {
        for (const double start : {0.1, 0.5, 0.9}) search(from(start), true, wide);
        if (!best_.feasible) search(closest_, true, fine);
      }
      if (best_.feasible) {
        for (const double start : {0.2, 0.8}) search(from(start), false, wide);
        for (const std::vector<double>& start : starts_) search(start, false, fine);
        // A search may end in a corner of its own simplex: again from the best with fresh ones,
        // while that gains a thousandth.
        for (double before = kNone; best_.goal < before * (1.0 - 1e-3) && !stopped_;) {
          before = best_.goal;
          for (const double step : {wide, fine}) search(at_best_, false, step);
        }
      }
    }
    best_.candidate = name;
    if (!best_.feasible) {
      best_.point = scale_.point(closest_.data());
      best_.goal = least_excess_;
    }
    best_.evaluations = evaluations_;
    return best_;
  }

 private:
  /// Works out a point and keeps it where it is the best or the closest so far.
  CutQuality quality_at(const double* x) {
    const CutQuality quality = evaluator_(scale_.point(x));
    ++evaluations_;
    keep(x, quality);
    return quality;
  }

  void keep(const double* x, const CutQuality& quality) {
    const double over = excess(limit_uses(problem_, quality)), goal = goal_of(problem_, quality);
    const std::vector<double> here(x, x + scale_.size());
    if (over < least_excess_) {
      least_excess_ = over;
      closest_ = here;
    }
    if (over <= kMet && goal < best_.goal) {
      best_.goal = goal;
      best_.point = scale_.point(x);
      best_.feasible = true;
      at_best_ = here;
    }
  }

  /// Between its lobes the limit of chatter has pockets, which no search finds from afar: a coarse
  /// grid first. Chatter is worked out where all else is met, the best goal first.
  void try_lattice() {
    ChoiceProblem quiet = problem_;
    quiet.limits.chatter.reset();
    const Evaluator evaluator(quiet, candidate_);
    struct Tried {
      double goal;
      std::size_t index;
      CutQuality quality;
    };
    const std::vector<std::vector<double>> points = lattice(6);
    std::vector<Tried> list;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const CutQuality quality = evaluator(scale_.point(points[i].data()));
      if (excess(limit_uses(quiet, quality)) > kMet) continue;
      list.push_back({goal_of(quiet, quality), i, quality});
    }
    std::sort(list.begin(), list.end(), [](const Tried& a, const Tried& b) {
      return std::pair(a.goal, a.index) < std::pair(b.goal, b.index);
    });
    constexpr std::size_t enough = 3;
    for (Tried& tried : list) {
      if (starts_.size() == enough) break;
      const std::vector<double>& x = points[tried.index];
      const auto known = chatter_.find(tried.index);
      if (known == chatter_.end()) {
        tried.quality = quality_at(x.data());
        chatter_[tried.index] = tried.quality.chatter;
      } else {
        tried.quality.chatter = known->second;
        keep(x.data(), tried.quality);
      }
      if (excess(limit_uses(problem_, tried.quality)) <= kMet) starts_.push_back(x);
    }
  }

  /// Points of the free variables, so many of each.
  std::vector<std::vector<double>> lattice(int points) const {
    std::vector<std::vector<double>> list{{}};
    for (unsigned k = 0; k < scale_.size(); ++k) {
      std::vector<std::vector<double>> longer;
      for (const std::vector<double>& x : list) {
        for (int i = 0; i < points; ++i) {
          longer.push_back(x);
          longer.back().push_back(static_cast<double>(i) / (points - 1));
        }
      }
      list = std::move(longer);
    }
    return list;
  }

  struct State {
    Search* search;
    bool restore;
    std::vector<double> x;
    CutQuality quality;
    std::vector<LimitUse> uses;

    void at(const double* from, unsigned n) {
      if (x.size() == n && std::equal(x.begin(), x.end(), from)) return;
      x.assign(from, from + n);
      quality = search->quality_at(from);
      uses = limit_uses(search->problem_, quality);
    }
  };

  static double objective(unsigned n, const double* x, double*, void* data) {
    auto& state = *static_cast<State*>(data);
    if (state.restore) return x[n - 1];
    state.at(x, n);
    return std::log(std::max(goal_of(state.search->problem_, state.quality), 1e-300));
  }
  static void constraints(unsigned m, double* result, unsigned n, const double* x, double*,
                          void* data) {
    auto& state = *static_cast<State*>(data);
    state.at(x, state.restore ? n - 1 : n);
    for (unsigned i = 0; i < m; ++i) {
      const double use = state.uses[i].use;
      // Above 2 by its logarithm, so that a far start does not drown the rest.
      const double over = use > 2.0 ? 1.0 + std::log(use / 2.0) : use - 1.0;
      result[i] = state.restore ? over - x[n - 1] : over;
    }
  }

  /// `restore`: the least excess, as an epigraph variable behind the others, instead of the goal.
  void solve(std::vector<double> x, bool restore, double step) {
    if (restore) x.push_back(1.0);
    const unsigned n = static_cast<unsigned>(x.size());
    State state{this, restore, {}, {}, {}};
    nlopt::opt cobyla(nlopt::LN_COBYLA, n);
    std::vector<double> low(n, 0.0), high(n, 1.0);
    if (restore) {
      low.back() = -1.0;
      high.back() = 100.0;
    }
    cobyla.set_lower_bounds(low);
    cobyla.set_upper_bounds(high);
    cobyla.set_min_objective(objective, &state);
    if (limits_ > 0) {
      cobyla.add_inequality_mconstraint(constraints, &state,
                                        std::vector<double>(limits_, 0.1 * kMet));
    }
    cobyla.set_initial_step(step);
    cobyla.set_xtol_rel(1e-5);
    cobyla.set_maxeval(600);
    if (restore) {
      // Which limits cannot be met shows long before the last digit of by how much; and a point
      // that meets them all ends the search for one.
      cobyla.set_xtol_rel(1e-4);
      cobyla.set_maxeval(200);
      cobyla.set_stopval(-kMet);
    }
    double goal = 0.0;
    try {
      cobyla.optimize(x, goal);
    } catch (const nlopt::roundoff_limited&) {
      // The best point has been kept on the way.
    }
  }

  const ChoiceProblem& problem_;
  const Candidate& candidate_;
  ChatterAt& chatter_;
  Evaluator evaluator_;
  Scale scale_;
  std::size_t limits_ = 0;
  int evaluations_ = 0;
  bool stopped_ = false;
  Choice best_;
  double least_excess_ = kNone;
  std::vector<double> closest_, at_best_;
  std::vector<std::vector<double>> starts_;
};

bool better(const Choice& a, const Choice& b) {
  if (a.feasible != b.feasible) return a.feasible;
  return a.goal < b.goal;
}

const Candidate& named(const std::vector<Candidate>& candidates, const std::string& name) {
  return *std::find_if(candidates.begin(), candidates.end(),
                       [&](const Candidate& c) { return c.name == name; });
}

Choice best_of(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
               std::vector<ChatterAt>& chatter, const Progress& progress = {},
               std::string_view doing = "choose") {
  std::vector<Choice> choices(candidates.size());
  chatter.resize(candidates.size());
  // Most candidates end after four or five searches.
  const double all = 5.0 * static_cast<double>(candidates.size());
  std::mutex reporting;
  double done = 0.0;
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    choices[i] = Search(problem, candidates[i], chatter[i]).run(candidates[i].name, [&] {
      const std::scoped_lock lock(reporting);
      done = std::min(all - 1.0, done + 1.0);
      return go_on(progress, doing, done / all);
    });
  });
  go_on(progress, doing, 1.0);
  Choice best = choices.front();
  int evaluations = 0;
  for (const Choice& choice : choices) {
    evaluations += choice.evaluations;
    if (better(choice, best)) best = choice;
  }
  best.evaluations = evaluations;
  return best;
}

void scale_limit(Limits& limits, const std::string& name, double factor, double start) {
  const auto one = [&](const char* known, std::optional<double>& limit) {
    if (name == known && limit) *limit *= factor;
  };
  one("time", limits.time);
  one("peak_force", limits.peak_force);
  one("deflection", limits.deflection);
  one("surface_error", limits.surface_error);
  one("power", limits.power);
  if (name == "temperature" && limits.temperature) {
    limits.temperature = start + factor * (*limits.temperature - start);
  }
  if (name == "chatter" && limits.chatter) *limits.chatter *= factor;
  if (name == "feed_per_tooth") limits.feed_per_tooth *= factor;
}

void finish(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
            Choice& choice) {
  choice.quality = Evaluator(problem, named(candidates, choice.candidate), true)(choice.point);
  const auto uses = limit_uses(problem, choice.quality);
  choice.status = choice.feasible ? "optimal" : "infeasible";
  for (const LimitUse& use : uses) {
    // Within half a per cent of full counts as binding: the optimiser's own tolerance is less.
    if (choice.feasible && use.use > 0.995) choice.binding.push_back(use.name);
    if (!choice.feasible && use.use > 1.0 + kMet) choice.violated.push_back(use);
  }
  for (std::size_t i = 0; i < kVariables; ++i) {
    const Span& span = problem.spans[i];
    if (span.high <= span.low * (1.0 + 1e-12)) continue;
    if (choice.point[i] > span.high * 0.999) {
      choice.binding.push_back(fmt::format("largest {}", variable_names()[i]));
    } else if (choice.point[i] < span.low * 1.001) {
      choice.binding.push_back(fmt::format("smallest {}", variable_names()[i]));
    }
  }
}

}  // namespace

Choice choose(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
              const Progress& progress) {
  check(problem, candidates);
  std::vector<ChatterAt> chatter;
  Choice choice = best_of(problem, candidates, chatter, progress);
  finish(problem, candidates, choice);
  if (!choice.feasible) return choice;
  for (const LimitUse& use : limit_uses(problem, choice.quality)) {
    if (use.use <= 0.995) continue;
    ChoiceProblem relaxed = problem;
    scale_limit(relaxed.limits, use.name, 1.1, problem.heat.start);
    const Choice other = best_of(relaxed, candidates, chatter, progress, "relax " + use.name);
    const double goal = std::min(other.goal, choice.goal);
    choice.relaxations.push_back({use.name, goal, 1.0 - goal / choice.goal});
  }
  return choice;
}

Choice choose_by_grid(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
                      int points) {
  check(problem, candidates);
  require_within("options.points", points, 2.0, 200.0, "");
  const Scale scale(problem.spans);
  std::size_t count = 1;
  for (unsigned k = 0; k < scale.size(); ++k) count *= static_cast<std::size_t>(points);
  std::vector<Choice> choices(candidates.size());
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t c) {
    const Evaluator evaluator(problem, candidates[c]);
    Choice& best = choices[c];
    best.candidate = candidates[c].name;
    double least_excess = kNone;
    Point closest{};
    for (std::size_t i = 0; i < count; ++i) {
      std::array<double, kVariables> x{};
      std::size_t rest = i;
      for (unsigned k = 0; k < scale.size(); ++k) {
        x[k] = static_cast<double>(rest % static_cast<std::size_t>(points)) / (points - 1);
        rest /= static_cast<std::size_t>(points);
      }
      const Point point = scale.point(x.data());
      const CutQuality quality = evaluator(point);
      const double over = excess(limit_uses(problem, quality));
      if (over < least_excess) {
        least_excess = over;
        closest = point;
      }
      if (over <= kMet && goal_of(problem, quality) < best.goal) {
        best.goal = goal_of(problem, quality);
        best.point = point;
        best.feasible = true;
      }
    }
    if (!best.feasible) {
      best.goal = least_excess;
      best.point = closest;
    }
    best.evaluations = static_cast<int>(count);
  });
  Choice best = choices.front();
  for (const Choice& choice : choices) {
    if (better(choice, best)) best = choice;
  }
  finish(problem, candidates, best);
  return best;
}

std::vector<ParetoPoint> pareto_front(const ChoiceProblem& problem,
                                      const std::vector<Candidate>& candidates, int points,
                                      const Progress& progress) {
  require_within("options.pareto_points", points, 2.0, 200.0, "");
  ChoiceProblem fastest = problem;
  fastest.goal = Goal::time;
  fastest.limits.surface_error.reset();
  std::vector<ChatterAt> chatter;
  Choice fast = best_of(fastest, candidates, chatter, progress, "fastest cut");
  if (!fast.feasible) return {};
  ChoiceProblem accurate = problem;
  accurate.goal = Goal::error;
  accurate.limits.surface_error.reset();
  Choice exact = best_of(accurate, candidates, chatter, progress, "most accurate cut");
  if (!exact.feasible) return {};
  finish(fastest, candidates, fast);
  finish(accurate, candidates, exact);
  // From the fastest cut's error down to the smallest one, by equal ratios; an error of nothing
  // (two straight flutes in a slot) is reached at once.
  const double high = fast.quality.surface_error;
  const double low = std::max(exact.quality.surface_error, 1e-3 * high);
  std::vector<ParetoPoint> front;
  for (int i = 0; i < points; ++i) {
    if (!go_on(progress, "Pareto front", static_cast<double>(i) / points)) break;
    ChoiceProblem one = fastest;
    if (high > 0.0) {
      one.limits.surface_error =
          high * std::pow(low / high, static_cast<double>(i) / (points - 1)) * (1.0 + kMet);
    }
    const Choice choice = best_of(one, candidates, chatter);
    if (!choice.feasible) continue;
    const CutQuality quality =
        Evaluator(problem, named(candidates, choice.candidate), true)(choice.point);
    front.push_back({quality.time, quality.surface_error, choice.candidate, choice.point});
  }
  std::vector<ParetoPoint> kept;
  for (const ParetoPoint& p : front) {
    const bool beaten = std::any_of(front.begin(), front.end(), [&](const ParetoPoint& q) {
      return q.time <= p.time && q.error <= p.error && (q.time < p.time || q.error < p.error);
    });
    const bool there = std::any_of(kept.begin(), kept.end(), [&](const ParetoPoint& q) {
      return std::abs(q.time - p.time) < 1e-6 * p.time && q.error == p.error;
    });
    if (!beaten && !there) kept.push_back(p);
  }
  std::sort(kept.begin(), kept.end(),
            [](const ParetoPoint& a, const ParetoPoint& b) { return a.time < b.time; });
  return kept;
}

}  // namespace osteomill::accuracy
