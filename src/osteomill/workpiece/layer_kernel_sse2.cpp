// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_WIDTH 2
// clang-format off
#include "osteomill/workpiece/batch.inc"
#include "osteomill/workpiece/layer_kernel.inc"
#include "osteomill/workpiece/pose_kernel.inc"
// clang-format on

namespace osteomill::workpiece::kernel {

const Functions kSse2 = {"sse2", stretches,   fill,           take,
                         share,  share_plane, pose_stretches, pose_fill};

}  // namespace osteomill::workpiece::kernel
