// Work in a forked copy of this process, so that what it leaves in memory is not left here.
#pragma once

#include <cstdio>
#include <functional>
#include <vector>

namespace lodestream::bench {

// Runs `write` in the copy and `read` here, at the two ends of one pipe. What `write` changes is so in the copy alone;
// it leaves without this process's destructors. Throws std::runtime_error where the work or the copying fails.
void run_in_copy(const std::function<void(std::FILE*)>& write, const std::function<void(std::FILE*)>& read);

// One value, or all of an array with its length before it. Throw std::runtime_error where the other end has gone.
void send_bytes(const void* bytes, std::size_t size, std::FILE* to);
void receive_bytes(void* bytes, std::size_t size, std::FILE* from);

template <class Element>
void send(const std::vector<Element>& elements, std::FILE* to) {
    const std::size_t count = elements.size();
    send_bytes(&count, sizeof count, to);
    send_bytes(elements.data(), count * sizeof(Element), to);
}

template <class Element>
std::vector<Element> receive(std::FILE* from) {
    std::size_t count = 0;
    receive_bytes(&count, sizeof count, from);
    std::vector<Element> elements(count);
    receive_bytes(elements.data(), count * sizeof(Element), from);
    return elements;
}

}  // namespace lodestream::bench
