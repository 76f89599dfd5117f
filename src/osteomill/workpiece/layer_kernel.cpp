// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/layer_kernel.hpp"

namespace osteomill::workpiece::kernel {

const Functions& best() {
  const auto has_avx512 = [] {
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
  };
  static const Functions& best = has_avx512()                          ? kAvx512
                                 : __builtin_cpu_supports("avx2") != 0 ? kAvx2
                                                                       : kSse2;
  return best;
}

}  // namespace osteomill::workpiece::kernel
