// The texts of S3's protocol: percent-encoding of URLs, and elements of XML. Private to
// common/store. Pure functions; thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace parallax {

// Encodes all but letters, digits, and "-._~", and, with `keep_slash`, "/". Source: RFC 3986, as
// SigV4 wants it.
std::string PercentEncode(std::string_view text, bool keep_slash);
// Decodes %XX, and "+" as a space. A "%" that begins no code stays.
std::string PercentDecode(std::string_view text);

// Returns the text of the first <name> in `xml`, which it points into; "" without.
std::string_view Element(std::string_view xml, const std::string& name);
// Returns the seconds since 1970 of a time such as "2009-10-12T17:50:30.000Z", in whole seconds; 0
// if it is none.
double UnixSecondsOf(std::string_view time);
// Returns the text with the characters & < > " as XML writes them.
std::string EscapeXml(std::string_view text);
// Returns the text with entities of ASCII characters ("&amp;", "&#38;", "&#x26;") as what they
// mean.
std::string UnescapeXml(std::string_view text);

}  // namespace parallax
