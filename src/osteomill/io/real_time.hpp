// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::io {

/// Asks for SCHED_FIFO for the calling thread and locked memory for its process; says whether the
/// system granted both. Threads and programs that are started afterwards run as any other.
bool ask_for_real_time(int priority = 80);

}  // namespace osteomill::io
