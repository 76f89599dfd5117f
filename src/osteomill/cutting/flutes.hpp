// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/envelope.hpp"

namespace osteomill::cutting {

/// Where the flutes are and what each of them has to cut: pitch, errors of radius, run-out.
class Flutes {
 public:
  explicit Flutes(const Cutter& cutter);

  int count() const { return static_cast<int>(angles_.size()); }
  /// Whether every flute cuts the same chip.
  bool equal() const { return equal_; }
  /// Angle by which flute j lags behind flute 0, rad.
  double angle(int flute) const { return angles_[static_cast<std::size_t>(flute)]; }
  /// How much farther out the edge of a flute is than the envelope, m.
  double deviation(int flute, const ProfilePoint& point) const;

  /// Uncut chip thickness of a flute, m, where the feed goes into the envelope by `into` = n · f >
  /// 0: the least over the flutes before it of (feed since then) · into + difference of deviation
  /// along the normal; <= 0 where an earlier flute has already taken it all. Equal flutes:
  /// f_z · into. [sutherland1986] for cylinders, along the normal of the envelope here.
  double chip(int flute, const ProfilePoint& point, double feed_per_tooth, double into) const;
  /// A chip over a range of `into`, from where it begins or where another flute before comes to
  /// decide it, up to the next piece: rise · into + start > 0.
  struct ChipPiece {
    double from = 0.0;  ///< of `into`, >= 0
    double rise = 0.0;  ///< m
    double start = 0.0;
  };
  /// The chip of a flute as pieces, smallest `into` first; none where it cuts nothing. `deviations`
  /// are those of all flutes at the point.
  void chip_pieces(int flute, const std::vector<double>& deviations, double sin_kappa,
                   double feed_per_tooth, std::vector<ChipPiece>& pieces) const;

 private:
  /// Turn since the flute that is so many before another passed, rad.
  double since(int flute, int before) const;

  std::vector<double> angles_;
  std::vector<double> errors_;
  RunOut run_out_;
  bool equal_ = true;
};

/// Uncut chip thickness along the radius of a trochoidal tooth path, m: exact, for a horizontal
/// feed and equal flutes. The earlier tooth passed the same ray when its own angle was theta + d,
/// r sin d = (c - a d) cos theta with a = c N/2 pi, and
///   h = r (1 - cos d) + (c - a d) sin theta.
/// For c << r it is c sin theta (Martellotti's approximation, [plaskos2006] eq. 3.3), which is also
/// taken for r < 2 c, next to the tip of a ball.
double trochoidal_chip(double radius, double feed_per_tooth, int flutes, double theta);

}  // namespace osteomill::cutting
