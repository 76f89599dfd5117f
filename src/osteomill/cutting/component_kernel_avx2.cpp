// SPDX-License-Identifier: BSD-3-Clause
#define OSTEOMILL_ARCH xsimd::fma3<xsimd::avx2>
#define OSTEOMILL_NAME evaluate_avx2
#include "osteomill/cutting/component_kernel.inc"
