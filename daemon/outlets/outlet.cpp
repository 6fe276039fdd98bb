#include "daemon/outlets/outlet.hpp"

#include <exception>

namespace dwell {

void call_each(std::initializer_list<Outlet*> outlets, const std::function<void(Outlet&)>& call) {
  std::exception_ptr failure;
  for (Outlet* const outlet : outlets) {
    if (outlet == nullptr) continue;
    try {
      call(*outlet);
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace dwell
