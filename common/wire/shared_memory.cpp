#include "common/wire/shared_memory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>
#include <thread>

#include "common/base/error.hpp"

namespace ricochet::wire {

struct SharedMemory::Segment {
  std::int64_t key = 0;
  RingMemory to_participant, to_coupler;
};

namespace {

static_assert(sizeof(RingMemory) == 262'272, "docs/wire.md tells where everything lies");

constexpr const char* label = "ricochet";                // shown as /memfd:ricochet where open files are listed
constexpr std::chrono::microseconds between_pieces{50};  // of a message that is larger than the ring
constexpr int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;  // a file that shrinks kills who reads it

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw ConfigError(fmt::format("the shared memory '{}' cannot be opened: {}", path, why));
}

std::int64_t random_key() {
  std::int64_t key = 0;
  if (getrandom(&key, sizeof key, 0) != static_cast<ssize_t>(sizeof key)) return 0;
  return key & std::numeric_limits<std::int64_t>::max();
}

void* map(int descriptor, std::size_t size) {
  void* address = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  return address == MAP_FAILED ? nullptr : address;
}

/// Takes `text` away from the front of `path`; false if something else stands there.
bool takes(std::string_view& path, std::string_view text) {
  if (!path.starts_with(text)) return false;
  path.remove_prefix(text.size());
  return true;
}

bool takes_digits(std::string_view& path) {
  const auto end = std::min(path.find_first_not_of("0123456789"), path.size());
  path.remove_prefix(end);
  return end > 0;
}

bool is_open_file_of_a_process(std::string_view path) {
  return takes(path, "/proc/") && takes_digits(path) && takes(path, "/fd/") && takes_digits(path) && path.empty();
}

/// The memory at `path`, and nothing else: opening a device or a pipe may do something.
int open_memory(const std::string& path, std::size_t size) {
  if (!is_open_file_of_a_process(path)) refuse(path, "expected /proc/PROCESS/fd/NUMBER");
  std::array<char, 64> target{};
  if (readlink(path.c_str(), target.data(), target.size() - 1) < 0) refuse(path, std::strerror(errno));
  if (std::string_view(target.data()).rfind(fmt::format("/memfd:{}", label), 0) != 0) {
    refuse(path, fmt::format("it is {}", target.data()));
  }
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) refuse(path, std::strerror(errno));
  struct stat status {};
  if ((fcntl(descriptor, F_GET_SEALS) & seals) != seals || fstat(descriptor, &status) != 0 ||
      status.st_size != static_cast<off_t>(size)) {
    close(descriptor);
    refuse(path, "it has another size, or one that may change: use the same release of ricochet on both ends");
  }
  return descriptor;
}

}  // namespace

std::unique_ptr<SharedMemory> SharedMemory::make() {
  const int descriptor = memfd_create(label, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor < 0) return nullptr;
  void* address = nullptr;
  if (ftruncate(descriptor, sizeof(Segment)) == 0 && fcntl(descriptor, F_ADD_SEALS, seals) == 0) {
    address = map(descriptor, sizeof(Segment));
  }
  if (!address) {
    close(descriptor);
    return nullptr;
  }
  std::unique_ptr<SharedMemory> memory(new SharedMemory(descriptor, address, End::participant));
  memory->segment_->key = random_key();
  return memory;
}

std::unique_ptr<SharedMemory> SharedMemory::open(const std::string& path, std::int64_t key) {
  const int descriptor = open_memory(path, sizeof(Segment));
  void* address = map(descriptor, sizeof(Segment));
  if (!address) {
    const std::string why = std::strerror(errno);
    close(descriptor);
    refuse(path, why);
  }
  std::unique_ptr<SharedMemory> memory(new SharedMemory(descriptor, address, End::coupler));
  if (memory->segment_->key != key) refuse(path, "it is that of another process");
  return memory;
}

/// The pages are zero at first, which is a `Segment` with empty rings; its members are used where they lie.
SharedMemory::SharedMemory(int descriptor, void* address, End end)
    : descriptor_(descriptor), segment_(static_cast<Segment*>(address)) {
  const bool participant = end == End::participant;
  sender_ = std::make_unique<RingSender>(participant ? segment_->to_coupler : segment_->to_participant);
  receiver_ = std::make_unique<RingReceiver>(participant ? segment_->to_participant : segment_->to_coupler);
}

SharedMemory::~SharedMemory() {
  munmap(segment_, sizeof(Segment));
  close(descriptor_);
}

std::string SharedMemory::path() const { return fmt::format("/proc/{}/fd/{}", getpid(), descriptor_); }

std::int64_t SharedMemory::key() const { return segment_->key; }

void SharedMemory::wait(Deadline until) {
  if (sender_->flush()) {
    receiver_->wait(until);
  } else {
    std::this_thread::sleep_for(between_pieces);
  }
}

void SharedMemory::flush_all() noexcept try {
  const auto deadline = Clock::now() + linger;
  while (!sender_->flush() && Clock::now() < deadline) std::this_thread::sleep_for(between_pieces);
} catch (const ProtocolError&) {
  // A process that puts nonsense into the memory does not read.
}

}  // namespace ricochet::wire
