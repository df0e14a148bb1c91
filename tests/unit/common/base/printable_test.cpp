#include "common/base/printable.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/suggest.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("harmless text is printed as it is") {
  CHECK(printable("").empty());
  CHECK(printable("gold-2 'fine' \\ ~/") == "gold-2 'fine' \\ ~/");
  const std::string beyond_ascii = "Z\xC3\xBCrich \xE2\x82\xAC \xF0\x9F\x98\x80";
  CHECK(printable(beyond_ascii) == beyond_ascii);
}

TEST_CASE("what could drive a terminal or hide in a line is escaped") {
  CHECK(printable("a\x1b[31m\n\t\x7f") == "a\\x1b[31m\\x0a\\x09\\x7f");
  CHECK(printable(std::string("\0", 1)) == "\\x00");
  CHECK(printable("\xC2\x9B[") == "\\u009b[");          // C1 control sequence introducer
  CHECK(printable("\xE2\x80\xA8txt") == "\\u2028txt");  // line separator
  const std::string right_to_left{'\xE2', '\x80', '\xAE'};
  CHECK(printable(right_to_left + "txt") == "\\u202etxt");
  CHECK(printable("\xEF\xBB\xBF") == "\\ufeff");
  const std::string arabic_mark{'\xD8', '\x9C'};
  CHECK(printable("a" + arabic_mark + "b") == "a\\u061cb");
  CHECK(printable("a\xE1\xA0\x8E") == "a\\u180e");          // Mongolian vowel separator
  CHECK(printable("a\xF3\xA0\x81\x81") == "a\\U000e0041");  // tag: an invisible A
  CHECK(printable("\xF3\xA0\x80\x80\xF3\xA0\x81\xBF") == "\\U000e0000\\U000e007f");
  CHECK(printable("\xD8\x9B") == "\xD8\x9B");  // Arabic semicolon
}

TEST_CASE("bytes that are not UTF-8 are escaped one by one") {
  CHECK(printable("\xFF\xFE") == "\\xff\\xfe");
  CHECK(printable("\xC0\x80") == "\\xc0\\x80");                    // overlong zero
  CHECK(printable("\xED\xA0\x80") == "\\xed\\xa0\\x80");           // surrogate
  CHECK(printable("\xF4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80");  // beyond U+10FFFF
  CHECK(printable("\xE2\x82") == "\\xe2\\x82");                    // cut short
}

TEST_CASE("long text is cut at a whole character") {
  CHECK(printable("0123456789", 10) == "0123456789");
  CHECK(printable("0123456789a", 10) == "0123456...");
  CHECK(printable("012345\xE2\x82\xACxy", 10) == "012345...");
  CHECK(printable("012345\x01\x01", 10) == "012345...");
  CHECK(printable(std::string(1000000, 'x')).size() == 60);
}

TEST_CASE("numbers are printed shortest") {
  CHECK(number_text(0.1) == "0.1");
  CHECK(number_text(-3) == "-3");
  CHECK(number_text(1e30) == "1e+30");
}

TEST_CASE("the nearest known word is suggested, and none that is far") {
  const auto nearest = [](std::string_view word) {
    NearestWord search(word);
    for (const auto* known : {"look_from", "look_at", "vfov", "aperture", "up"}) {
      search.offer(known);
    }
    return search.best();
  };
  CHECK(nearest("vfow") == "vfov");
  CHECK(nearest("vofv") == "vfov");
  CHECK(nearest("VFOV") == "vfov");
  CHECK(nearest("lookFrom") == "look_from");
  CHECK(nearest("apperture") == "aperture");
  CHECK(nearest("u") == "up");
  CHECK(nearest("fov") == "vfov");
  CHECK(nearest("zoom").empty());
  CHECK(nearest("").empty());
  CHECK(nearest(std::string(100000, 'v')).empty());
}

TEST_CASE("of equally near words the first is suggested") {
  NearestWord search("cat");
  search.offer("bat");
  search.offer("rat");
  CHECK(search.best() == "bat");
}

}  // namespace parray
