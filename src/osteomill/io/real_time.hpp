// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::io {

/// Asks for SCHED_FIFO and locked memory for the calling thread's process; says whether the system
/// granted both. Programs that are started afterwards run as any other.
bool ask_for_real_time();

}  // namespace osteomill::io
