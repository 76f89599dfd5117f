// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/slice.hpp"

#include <algorithm>
#include <map>

namespace osteomill::study {

std::vector<Factor> Slice::factors() const {
  std::vector<Factor> all = between;
  all.insert(all.end(), within.begin(), within.end());
  return all;
}

Factor subset(const Factor& factor, const std::vector<bool>& keep) {
  std::vector<int> renamed(factor.levels.size(), -1);
  for (size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] && factor.level[i] >= 0) renamed[factor.level[i]] = 0;
  }
  Factor result{factor.name, {}, {}};
  for (size_t k = 0; k < renamed.size(); ++k) {
    if (renamed[k] < 0) continue;
    renamed[k] = static_cast<int>(result.levels.size());
    result.levels.push_back(factor.levels[k]);
  }
  for (size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) result.level.push_back(factor.level[i] < 0 ? -1 : renamed[factor.level[i]]);
  }
  return result;
}

Slice subset(const Slice& slice, const std::vector<bool>& keep) {
  Slice result;
  result.response = slice.response;
  const auto count = std::count(keep.begin(), keep.end(), true);
  const auto pick = [&](const Eigen::VectorXd& all) {
    Eigen::VectorXd some(count);
    for (size_t i = 0, at = 0; i < keep.size(); ++i) {
      if (keep[i]) some(static_cast<Eigen::Index>(at++)) = all(static_cast<Eigen::Index>(i));
    }
    return some;
  };
  const auto pick_factors = [&](const std::vector<Factor>& all) {
    std::vector<Factor> some;
    for (const Factor& factor : all) some.push_back(subset(factor, keep));
    return some;
  };
  result.y = pick(slice.y);
  result.between = pick_factors(slice.between);
  result.within = pick_factors(slice.within);
  result.blocks = pick_factors(slice.blocks);
  result.random = pick_factors(slice.random);
  if (slice.subject) result.subject = subset(*slice.subject, keep);
  for (const Covariate& covariate : slice.covariates) {
    result.covariates.push_back({covariate.name, pick(covariate.value)});
  }
  result.cell = subset(slice.cell, keep);
  for (size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) result.lines.push_back(slice.lines[i]);
  }
  return result;
}

Factor combined(const std::vector<Factor>& factors, int rows) {
  Factor result;
  for (const Factor& factor : factors) {
    result.name += (result.name.empty() ? "" : " × ") + factor.name;
  }
  if (factors.empty()) {
    return {"all", {"all"}, std::vector<int>(static_cast<size_t>(rows), 0)};
  }
  std::map<std::vector<int>, int> order;
  std::vector<std::vector<int>> keys(static_cast<size_t>(rows));
  for (size_t i = 0; i < keys.size(); ++i) {
    for (const Factor& factor : factors) keys[i].push_back(factor.level[i]);
    order.emplace(keys[i], 0);
  }
  for (auto& [key, index] : order) {
    index = static_cast<int>(result.levels.size());
    std::string name;
    for (size_t f = 0; f < factors.size(); ++f) {
      const std::string level = key[f] < 0 ? std::string("?") : factors[f].levels[key[f]];
      name += (f == 0 ? "" : " × ") + level;
    }
    result.levels.push_back(std::move(name));
  }
  for (const std::vector<int>& key : keys) result.level.push_back(order[key]);
  return result;
}

std::vector<Factor> groupings(const Slice& slice) {
  const int rows = static_cast<int>(slice.y.size());
  std::vector<Factor> all{combined({}, rows)};
  const std::vector<Factor> factors = slice.factors();
  all.insert(all.end(), factors.begin(), factors.end());
  if (factors.size() > 1) all.push_back(combined(factors, rows));
  return all;
}

std::vector<bool> rows_at(const Factor& factor, int level) {
  std::vector<bool> keep;
  for (const int l : factor.level) keep.push_back(l == level);
  return keep;
}

std::vector<double> values_at(const Slice& slice, const Factor& factor, int level) {
  std::vector<double> values;
  for (size_t i = 0; i < factor.level.size(); ++i) {
    if (factor.level[i] == level) values.push_back(slice.y(static_cast<Eigen::Index>(i)));
  }
  return values;
}

}  // namespace osteomill::study
