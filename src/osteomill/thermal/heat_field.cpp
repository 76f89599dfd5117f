// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/heat_field.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::thermal {

namespace {

constexpr int kLanes = 16;  // lines that are solved side by side
// Rows that are fetched before they are due: along y and z each lies on a page of its own, which
// the processor doesn't foresee.
constexpr std::size_t kAhead = 6;

}  // namespace

HeatField::HeatField(const geometry::GridShape& shape,
                     const std::function<ThermalMaterial(int x, int y, int z)>& material,
                     const HeatOptions& options)
    : shape_(shape), options_(options) {
  for (double spacing : shape.spacing)
    require_positive("heat.spacing_mm", spacing / units::mm, "mm");
  for (int size : shape.size) require_within("heat.size", size, 1, 1 << 20, "voxels");
  require_positive("heat.initial_temperature", options.initial_temperature, "K");
  require_positive("heat.coolant_temperature", options.coolant_temperature, "K");
  require_positive("heat.blood_temperature", options.blood_temperature, "K");
  require_non_negative("heat.convection", options.convection, "W/m²K");
  require_non_negative("heat.perfusion", options.perfusion, "W/m³K");
  const std::size_t count = shape.count();
  rise_.assign(count, 0.0);
  capacity_.assign(count, 0.0f);
  conductivity_.assign(count, 0.0f);
  for (int axis = 0; axis < 3; ++axis) {
    conductance_[axis].assign(count, 0.0f);
    open_[axis].assign(count, 0.0f);
  }
  coolant_rise_ = options.coolant_temperature - options.initial_temperature;
  blood_rise_ = options.blood_temperature - options.initial_temperature;
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) {
        const ThermalMaterial here = material(x, y, z);
        if (here.heat_capacity == 0.0) continue;
        require_positive("heat.heat_capacity", here.heat_capacity, "J/m³K");
        require_positive("heat.conductivity", here.conductivity, "W/mK");
        capacity_[shape.index(x, y, z)] =
            static_cast<float>(here.heat_capacity * shape.voxel_volume());
        conductivity_[shape.index(x, y, z)] = static_cast<float>(here.conductivity);
      }
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) update_faces(x, y, z);
}

void HeatField::update_faces(int x, int y, int z) {
  const std::size_t here = shape_.index(x, y, z);
  const std::array<int, 3> at{x, y, z};
  const std::size_t stride[3] = {
      1, static_cast<std::size_t>(shape_.size[0]),
      static_cast<std::size_t>(shape_.size[0]) * static_cast<std::size_t>(shape_.size[1])};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    conductance_[axis][here] = 0.0f;
    open_[axis][here] = 0.0f;
    if (capacity_[here] == 0.0f) continue;
    const double half = 0.5 * shape_.spacing[static_cast<Eigen::Index>(axis)];
    const double area = shape_.voxel_volume() / (2.0 * half);
    const double k = conductivity_[here];
    const double to_coolant =
        options_.convection > 0.0 ? area / (half / k + 1.0 / options_.convection) : 0.0;
    if (at[axis] > 0 && capacity_[here - stride[axis]] == 0.0f)
      open_[axis][here] += static_cast<float>(to_coolant);
    if (at[axis] + 1 == shape_.size[axis]) continue;
    const std::size_t next = here + stride[axis];
    if (capacity_[next] == 0.0f)
      open_[axis][here] += static_cast<float>(to_coolant);
    else
      conductance_[axis][here] =
          static_cast<float>(area / (half / k + half / static_cast<double>(conductivity_[next])));
  }
}

bool HeatField::add_heat(int x, int y, int z, double heat) {
  const std::size_t at = shape_.index(x, y, z);
  if (capacity_[at] == 0.0f) return false;
  rise_[at] += heat / static_cast<double>(capacity_[at]);
  added_ += heat;
  return true;
}

void HeatField::remove(int x, int y, int z) {
  const std::size_t at = shape_.index(x, y, z);
  if (capacity_[at] == 0.0f) return;
  cut_ += rise_[at] * static_cast<double>(capacity_[at]);
  rise_[at] = 0.0;
  capacity_[at] = 0.0f;
  update_faces(x, y, z);
  if (x > 0) update_faces(x - 1, y, z);
  if (y > 0) update_faces(x, y - 1, z);
  if (z > 0) update_faces(x, y, z - 1);
  if (x + 1 < shape_.size[0]) update_faces(x + 1, y, z);
  if (y + 1 < shape_.size[1]) update_faces(x, y + 1, z);
  if (z + 1 < shape_.size[2]) update_faces(x, y, z + 1);
}

/// Thomas' elimination of `lanes` lines at once: lane l begins at start + l lane_stride, its voxels
/// are `stride` apart. Rows without bone decouple by themselves: all their conductances are 0.
/// The temperatures are written as old + change: the elimination in single precision then rounds
/// the change only, and the change is put in balance with what flows through the faces.
template <int lanes>
void HeatField::solve(std::size_t start, std::size_t lane_stride, std::size_t stride, int length,
                      int axis, float time, std::vector<float>& work) {
  const std::size_t rows = static_cast<std::size_t>(length) * lanes;
  work.resize(std::max(work.size(), 2 * rows));
  float* upper = work.data();
  float* change = work.data() + rows;
  const float* conductance = conductance_[axis].data();
  const float* open = open_[axis].data();
  double* rise = rise_.data();
  const float* capacity = capacity_.data();
  const float coolant = static_cast<float>(coolant_rise_);
  // Of x'th row: -a c[i-1] + b c[i] - d c[i+1] = flow of the old temperatures, c the change.
  float before[lanes] = {};  // conductance to the row before, times time
  float upper_before[lanes] = {};
  float change_before[lanes] = {};
  double flow_before[lanes] = {};  // from the row before, at the old temperatures
  for (int i = 0; i < length; ++i) {
    const std::size_t row = start + static_cast<std::size_t>(i) * stride;
    float* up = upper + static_cast<std::size_t>(i) * lanes;
    float* ch = change + static_cast<std::size_t>(i) * lanes;
    if (stride > 1 && static_cast<std::size_t>(i) + kAhead < static_cast<std::size_t>(length)) {
      const std::size_t ahead = row + kAhead * stride;
      __builtin_prefetch(rise + ahead, 1);
      __builtin_prefetch(rise + ahead + lanes / 2, 1);
      __builtin_prefetch(capacity + ahead);
      __builtin_prefetch(conductance + ahead);
      __builtin_prefetch(open + ahead);
    }
    for (int l = 0; l < lanes; ++l) {
      const std::size_t at = row + static_cast<std::size_t>(l) * lane_stride;
      const float after = i + 1 < length ? conductance[at] * time : 0.0f;
      const float out = open[at] * time;
      const double here = rise[at];
      const double flow_after =
          after > 0.0f ? static_cast<double>(after) * (rise[at + stride] - here) : 0.0;
      const float held = capacity[at] > 0.0f ? capacity[at] : 1.0f;
      const float right =
          static_cast<float>(flow_after - flow_before[l] +
                             static_cast<double>(out) * (static_cast<double>(coolant) - here));
      const float pivot = 1.0f / (held + before[l] + after + out - before[l] * upper_before[l]);
      upper_before[l] = after * pivot;
      change_before[l] = (right + before[l] * change_before[l]) * pivot;
      before[l] = after;
      flow_before[l] = flow_after;
      up[l] = upper_before[l];
      ch[l] = change_before[l];
    }
  }
  float change_after[lanes] = {};
  for (int i = length - 1; i >= 0; --i) {
    const std::size_t row = start + static_cast<std::size_t>(i) * stride;
    const float* up = upper + static_cast<std::size_t>(i) * lanes;
    float* ch = change + static_cast<std::size_t>(i) * lanes;
    for (int l = 0; l < lanes; ++l) {
      change_after[l] = ch[l] + up[l] * change_after[l];
      ch[l] = change_after[l];
      rise[row + static_cast<std::size_t>(l) * lane_stride] += static_cast<double>(ch[l]);
    }
  }
}

void HeatField::sweep(int axis, double time) {
  const std::size_t nx = static_cast<std::size_t>(shape_.size[0]);
  const std::size_t ny = static_cast<std::size_t>(shape_.size[1]);
  const std::size_t nz = static_cast<std::size_t>(shape_.size[2]);
  const float step = static_cast<float>(time);
  // Lines that lie side by side, in planes: along x they are the rows of a layer, otherwise the
  // columns of neighbouring x.
  const std::size_t planes = axis == 2 ? ny : nz;
  const std::size_t plane_stride = axis == 2 ? nx : nx * ny;
  const std::size_t lines = axis == 0 ? ny : nx;
  const std::size_t lane_stride = axis == 0 ? nx : 1;
  const std::size_t stride = axis == 0 ? 1 : axis == 1 ? nx : nx * ny;
  const int length = shape_.size[static_cast<std::size_t>(axis)];
  if (length == 1) return;
  const std::size_t blocks = (lines + kLanes - 1) / kLanes;
  tbb::enumerable_thread_specific<std::vector<float>> work;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, planes * blocks),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      std::vector<float>& mine = work.local();
                      for (std::size_t at = range.begin(); at < range.end(); ++at) {
                        const std::size_t first = at % blocks * kLanes;
                        const std::size_t start = at / blocks * plane_stride + first * lane_stride;
                        if (first + kLanes <= lines) {
                          solve<kLanes>(start, lane_stride, stride, length, axis, step, mine);
                        } else {
                          for (std::size_t line = first; line < lines; ++line)
                            solve<1>(start + (line - first) * lane_stride, lane_stride, stride,
                                     length, axis, step, mine);
                        }
                      }
                    });
}

void HeatField::advance(double time) {
  require_positive("heat.step_s", time, "s");
  if (options_.perfusion > 0.0) {
    const double volume = shape_.voxel_volume();
    for (std::size_t at = 0; at < rise_.size(); ++at) {
      if (capacity_[at] == 0.0f) continue;
      const double flow = options_.perfusion * volume * time / static_cast<double>(capacity_[at]);
      rise_[at] = (rise_[at] + flow * blood_rise_) / (1.0 + flow);
    }
  }
  for (int k = 0; k < 3; ++k) sweep(backwards_ ? 2 - k : k, time);
  backwards_ = !backwards_;
}

double HeatField::temperature(int x, int y, int z) const {
  const std::size_t at = shape_.index(x, y, z);
  return capacity_[at] > 0.0f ? options_.initial_temperature + rise_[at]
                              : options_.coolant_temperature;
}

double HeatField::energy() const {
  // Layer by layer, so that the sum keeps its digits.
  double sum = 0.0;
  const std::size_t layer =
      static_cast<std::size_t>(shape_.size[0]) * static_cast<std::size_t>(shape_.size[1]);
  for (std::size_t start = 0; start < rise_.size(); start += layer) {
    double part = 0.0;
    for (std::size_t at = start; at < start + layer; ++at)
      part += rise_[at] * static_cast<double>(capacity_[at]);
    sum += part;
  }
  return sum;
}

double HeatField::hottest() const {
  double highest = -options_.initial_temperature;
  for (std::size_t at = 0; at < rise_.size(); ++at)
    if (capacity_[at] > 0.0f) highest = std::max(highest, rise_[at]);
  return options_.initial_temperature + highest;
}

}  // namespace osteomill::thermal
