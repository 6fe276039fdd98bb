// Whether a request's Host names this service: the defence against DNS rebinding, where a page of a foreign site has
// its own name resolve to this computer and then reads what is served here with the visitor's browser.
//
// A browser always sends the name under which the page was loaded. So a numeric address is never foreign; of names only
// "localhost" and the given ones are ours.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dwell {

// host: the field's value, NAME[:PORT]; the port is not looked at. Letter case and one dot at the end of a name make no
// difference. Pure.
[[nodiscard]] bool is_our_host(std::string_view host, const std::vector<std::string>& names);

// Whether two names are the same but for letter case. Pure.
[[nodiscard]] bool same_name(std::string_view a, std::string_view b) noexcept;

}  // namespace dwell
