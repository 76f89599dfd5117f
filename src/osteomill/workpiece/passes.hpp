// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Which way the edges run through bone that lies on one side of the tool. Spindles turn clockwise
/// seen from above: with the bone on the right of the feed the chip begins thick, down-milling.
enum class Milling { down, up };

/// The lines in the direction that leaves the bone of the next line on the wanted side. Throws
/// InvalidInput when the step between lines is not to a side.
Lines directed(Lines lines, Milling milling);

/// The lines all in that direction, with the way back above the bone.
ToolPath one_way(const Lines& lines, const CutSettings& cut, Milling milling);

/// Each line as a rough pass down-milling and back over it as a finishing pass up-milling, then on
/// to the next: [plaskos2006] 3.5.5. The rough pass is pushed off the surface by its force and
/// leaves a little; the finishing pass, pulled towards it by a small one, takes that.
struct RoughAndFinish {
  Lines lines;
  /// By how much the rough pass stays off: 0 as in the source, where the tool's deflection does it.
  Vector3 allowance_W = Vector3::Zero();
  double finish_feed = 0.0;  ///< m/s; 0: that of the rough pass
};
ToolPath rough_and_finish(const RoughAndFinish& passes, const CutSettings& cut);

}  // namespace osteomill::workpiece
