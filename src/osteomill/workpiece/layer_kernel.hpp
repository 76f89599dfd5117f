// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

/// The loops of removal over the rows of a layer of voxels, see Swath and Remover. One translation
/// unit an instruction set, each compiled with its own flags: nothing here may be an inline
/// function of a shared header. No instruction set fuses a product and a sum, so that all give the
/// same bits. All lengths in voxels.
namespace osteomill::workpiece::kernel {

/// Neighbouring voxels of one row.
struct Run {
  int y = 0;
  int first = 0, last = 0;            ///< x
  std::size_t fresh = 0;              ///< place of the fresh occupancy of start_of(run)
  int gone_first = 1, gone_last = 0;  ///< x between which nothing stays
};

// Static: each translation unit has its own.
static inline int start_of(const Run& run) { return run.first / 8 * 8; }
static inline int lanes_of(const Run& run) { return run.last / 8 * 8 + 8 - start_of(run); }

/// What the rows of a step have in common in all layers, an array over them each. A multiple of
/// eight rows is there to be read.
struct Rows {
  const double *from_sq, *to_sq;           ///< offset from the start and the end, squared
  const double *ahead_low, *ahead_high;    ///< x ahead of the start
  const double *beside_low, *beside_high;  ///< x between start and end along the feed
  const double* centre;                    ///< x on the line of the feed
};

/// Of a layer: which x of a row the step meets.
struct Section {
  double from_x, to_x;
  double outer, inner, gone;  ///< radii: reached, all gone, taken before; < 0: nowhere
  double slant;               ///< 1/|sine| between feed and rows; 0: the feed is along them
  bool from_too;              ///< also what is around the start
  bool moves;
  double last_x;  ///< of the grid
};

/// Integer x of each row: two stretches to look at, and where all goes. Empty: first > last.
struct Stretches {
  int *first[2], *last[2];
  int *gone_first, *gone_last;  ///< not of a leaning tool
};

/// Of a layer in which the distance to the cutter is root(r² + under_sq) - radius.
struct Wall {
  double from_x, from_y;
  double hx, hy, run;  ///< the feed
  double under_sq;
  double offset;  ///< half a voxel - radius
};

/// A leaning tool as a layer sees it: voxel (x, y) is at base + y per_y + x along in its frame.
struct View {
  double base[3], per_y[3], along[3];
};

/// A ball with its shank above, or a cylinder.
struct Solid {
  View view;
  double radius;
  double floor;  ///< of the part at full radius
  bool ball;
};

/// What a leaning tool leaves, see PoseSwath: a ball, or a cylinder that stays at its height.
struct Pass {
  View from, to;
  double radius;
  bool ball;
  bool placing;
  bool turns;  ///< the axis does
};

/// A layer of the stock.
struct Layer {
  const std::uint32_t* tiles;  ///< numbers, x fastest
  int tiles_along_x;
  std::size_t in_tile;  ///< of the layer
  std::uint16_t* occupancy;
  const std::uint16_t* material;
  std::int64_t* row_units;  ///< of each row of tiles
  const double *density, *force_scale;
  bool one_material;
};

/// What a layer gave, in units; of several materials in units × force scale.
struct Amounts {
  float* of_voxels;  ///< beside the fresh occupancies
  float* of_runs;
  std::uint32_t* units;  ///< of the runs; a run without any has no other amounts
};

struct Taken {
  std::int64_t units = 0;
  double unit_density = 0.0;  ///< units × kg/m³
  double unit_scale = 0.0;    ///< units × force scale
  bool alike = false;         ///< amounts and units are those that were there, if compared
};

/// A plane of cells that the voxels of a layer are shared between where both coordinates change
/// along a row: lateral and eta, see ShadowMap. A coordinate is origin + x x_rate + y y_rate.
struct Plane {
  double origin[2], x_rate[2], y_rate[2];
  int phase_bits;
  const float* four_shares[2];  ///< see FourShadows
  int first_cell[2];
  float gain;
  int rows, stride;
  float* cells;
};

/// Of a plane of cells. Empty: first > last.
struct RowRange {
  int first, last;
};

/// A line of cells that the voxels of a layer are shared between, see ShadowMap. The coordinate of
/// a voxel among the cells is origin + x x_rate + y y_rate.
struct Line {
  double origin, x_rate, y_rate;
  int phase_bits;
  const float* shares;  ///< of one voxel, by phase, `stride` apart: cells before, at and after it
  int stride;
  const float* four_shares;  ///< of four voxels in a row, see FourShadows
  int first_cell;
  bool along_x;        ///< the feed is: the coordinate is the same all along a row
  std::size_t length;  ///< a multiple of four
  float* cells;        ///< 4 length, of which the first `length` are the line
};

struct Functions {
  const char* name;
  /// Rows first ... last (counted in Rows), and some before and after them.
  void (*stretches)(const Rows&, const Section&, int first, int last, const Stretches& out);
  /// Fresh occupancies of whole groups of eight voxels.
  void (*fill)(const Wall&, const Run* runs, std::size_t count, std::uint16_t* fresh);
  /// Takes what the runs say.
  Taken (*take)(const Layer&, const Run* runs, std::size_t count, const std::uint16_t* fresh,
                bool compare, const Amounts& out);
  /// Shares the amounts of a layer. Returns whether there were any.
  bool (*share)(const Line&, const Run* runs, std::size_t count, const Amounts&);
  /// The same between the cells of a plane, which are added to. Returns the rows of cells; voxels
  /// beyond the last row are left out.
  RowRange (*share_plane)(const Plane&, const Run* runs, std::size_t count, const Amounts&);
  /// x in the one and not in the other, if there is one, where a tool at the other that goes this
  /// way (of a point, in its frame; null: not the same everywhere) comes nearer. In rows
  /// first_y ... last_y and some behind them.
  void (*pose_stretches)(const Solid&, const Solid* without, const double* way, int first_y,
                         int last_y, double last_x, const Stretches& out);
  /// Fresh occupancies of the runs, kNothing where nothing changes. Returns how many runs are left:
  /// those in which something changes.
  std::size_t (*pose_fill)(const Pass&, Run* runs, std::size_t count, std::uint16_t* fresh);
};

extern const Functions kSse2;
extern const Functions kAvx2;
extern const Functions kAvx512;

/// The widest that this machine has.
const Functions& best();

}  // namespace osteomill::workpiece::kernel
