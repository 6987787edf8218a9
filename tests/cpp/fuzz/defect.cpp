// libFuzzer: a defect that is there on purpose. The tests must find it, or they find nothing.
#include <cstdint>
#include <cstring>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size < 6 || std::memcmp(data, "defect", 6) != 0) return 0;
    const std::vector<char> bytes(data, data + size);
    const volatile char* const first = bytes.data();
    [[maybe_unused]] const char beyond = first[size];
    return 0;
}
