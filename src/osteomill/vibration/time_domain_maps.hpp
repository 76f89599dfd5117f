// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/vibration/floquet.hpp"
#include "osteomill/vibration/regeneration.hpp"

namespace osteomill::vibration {

/// Steps of a tooth period that keep the error of the limit depth below 0.5 % for one- and
/// two-direction milling: 40 for each oscillation of the fastest mode, and never fewer than 40.
int default_steps(const RegenerativeSystem& system, double spindle_speed);

/// The cut over one tooth period by first-order semi-discretisation: directional coefficients at
/// their mean over each step, the delayed displacement linear, the step exact; [insperger2004].
DelayMap semi_discretisation(const RegenerativeSystem& system, double spindle_speed, double depth,
                             int steps);

/// The same by full discretisation: the regenerative term too is linear over a step, so that the
/// exponentials belong to the structure alone and serve all depths of one speed; [ding2010], with
/// the directional coefficients at their mean over each step instead of their value at its ends.
DelayMap full_discretisation(const RegenerativeSystem& system, double spindle_speed, double depth,
                             int steps);

/// The dominant multiplier by collocation at three Gauss points an element, elements laid between
/// the angles at which the cut begins and ends: an independent reference of high order.
Multiplier collocation_multiplier(const RegenerativeSystem& system, double spindle_speed,
                                  double depth, int elements);

}  // namespace osteomill::vibration
