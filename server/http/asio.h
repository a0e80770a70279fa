// Boost.Asio and Boost.Beast under short names. Private to http.
// GCC 12 miscompiles a co_await inside a conditional expression and coroutines that await each other in a circle: give
// every awaited value a name.
#pragma once

#include <utility>  // before Asio: its coroutines use std::exchange without including it (Boost 1.81, GCC 12)

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace lodestream::http {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Tcp = asio::ip::tcp;

// Errors come as values: auto [error, …] = co_await operation(…, as_values);
inline constexpr auto as_values = asio::as_tuple(asio::use_awaitable);

}  // namespace lodestream::http
