#pragma once

#include <spdlog/fmt/fmt.h>
#include <spdlog/logger.h>

// libfmt 9 contains the function that formats a line. With this declaration, no source that logs
// compiles it again, which would take two seconds each. Debian builds libfmt with GCC, and Clang
// calls the function by another symbol, so a program would not link. Header-only libfmt has no such
// symbol at all.
#if FMT_VERSION / 10000 == 9 && !defined(__clang__) && !defined(FMT_HEADER_ONLY)
extern template void fmt::detail::vformat_to<char>(fmt::detail::buffer<char>&,
                                                   fmt::basic_string_view<char>,
                                                   fmt::basic_format_args<fmt::format_context>,
                                                   fmt::detail::locale_ref);
#endif
