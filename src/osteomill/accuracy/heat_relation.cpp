// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/heat_relation.hpp"

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {

double rubbing(double edge_length, double spindle_speed, int flutes, double feed_rate) {
  require_non_negative("edge length", edge_length / units::mm, "mm");
  require_positive("cut.spindle_speed_rpm", spindle_speed / units::rpm, "rpm");
  require_positive("feed rate", feed_rate / units::mm_per_s, "mm/s");
  return edge_length * spindle_speed * flutes / feed_rate;
}

double temperature(const HeatRelation& relation, double edge_length, double spindle_speed,
                   int flutes, double feed_rate) {
  return relation.start +
         relation.coefficient * rubbing(edge_length, spindle_speed, flutes, feed_rate);
}

HeatCalibration calibrate(const std::vector<HeatObservation>& observations, double start) {
  if (observations.empty()) {
    throw InvalidInput(Fault{"heat.observations", "", "at least one temperature is needed", ""});
  }
  double xx = 0.0, xy = 0.0;
  for (const HeatObservation& o : observations) {
    const double x = rubbing(o.edge_length, o.spindle_speed, o.flutes, o.feed_rate);
    xx += x * x;
    xy += x * (o.temperature - start);
  }
  require_positive("rubbing of the observations", xx, "");
  HeatCalibration result{.relation = {xy / xx, start}};
  double squares = 0.0;
  for (const HeatObservation& o : observations) {
    const double miss = o.temperature - temperature(result.relation, o.edge_length, o.spindle_speed,
                                                    o.flutes, o.feed_rate);
    squares += miss * miss;
  }
  const double n = static_cast<double>(observations.size());
  result.residual_rms = std::sqrt(squares / n);
  if (observations.size() > 1) result.coefficient_error = std::sqrt(squares / (n - 1.0) / xx);
  return result;
}

}  // namespace osteomill::accuracy
