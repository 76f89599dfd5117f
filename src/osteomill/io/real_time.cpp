// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/real_time.hpp"

#include <sched.h>
#include <sys/mman.h>

namespace osteomill::io {

bool ask_for_real_time(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  return sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted) == 0 &&
         mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

}  // namespace osteomill::io
