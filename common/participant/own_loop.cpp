#include "common/participant/own_loop.hpp"

#include <algorithm>
#include <semaphore>
#include <thread>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::participant {

/// The participant that `serve` runs in its thread: it passes each window to the loop and sleeps until that is done.
/// The two semaphores see to it that only one of the two threads is at work, so nothing else needs a lock.
class OwnLoop::Relay : public Participant {
 public:
  Relay(Description description, ServeOptions options)
      : description_(std::move(description)), options_(std::move(options)) {}

  Description describe() override { return description_; }
  void initialize(const Setup& given, LinkOutput& output) override {
    setup = given;
    hand_over();
    output = written;
  }
  void synchronise(Integration given, const std::vector<double>& link_input, LinkOutput& output) override {
    integration = given;
    time_step = 0.0;
    restore = std::exchange(tried_, false);
    save = false;
    pass(link_input, output);
  }
  void advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) override {
    time_step = setup.clock.size_s(window);
    restore = std::exchange(tried_, true);
    const auto& capabilities = description_.capabilities;
    save = !restore &&
           std::find(capabilities.begin(), capabilities.end(), Capability::repeat_window) != capabilities.end();
    pass(link_input, output);
  }
  void reconfigure(const Setup& given) override { setup = given; }
  void accept() override { tried_ = false; }
  void record(std::vector<double>& row) override { row.insert(row.end(), recorded.begin(), recorded.end()); }

  // for the loop's thread
  void start() {
    thread_ = std::thread([this] {
      exit_code = serve(*this, options_);
      over = true;
      to_loop_.release();
    });
    wait();
    setting_up = true;
  }
  void resume() {
    to_coupler_.release();
    wait();
  }
  /// The first question about a window is asked when the solver is ready for it.
  void end_setup() {
    if (std::exchange(setting_up, false)) resume();
  }
  void leave() {
    if (!thread_.joinable()) return;
    left_ = !over;
    if (left_) to_coupler_.release();
    thread_.join();
  }

  Setup setup;
  Integration integration = Integration::implicit_newmark;
  double time_step = 0.0;
  bool setting_up = false, save = false, restore = false, over = false;
  std::vector<double> input, recorded;
  LinkOutput written;
  int exit_code = static_cast<int>(ExitCode::participant);

 private:
  void pass(const std::vector<double>& link_input, LinkOutput& output) {
    input = link_input;
    hand_over();
    output = written;
  }
  void hand_over() {
    to_loop_.release();
    to_coupler_.acquire();
    if (left_) throw ParticipantError("the solver left its time loop before the run was over");
  }
  void wait() {
    to_loop_.acquire();
    if (over && exit_code != 0) throw Error(static_cast<ExitCode>(exit_code), "the coupled run failed");
  }

  Description description_;
  ServeOptions options_;
  std::binary_semaphore to_loop_{0}, to_coupler_{0};
  bool left_ = false, tried_ = false;  ///< tried: a window that is not accepted
  std::thread thread_;
};

OwnLoop::OwnLoop(Description description, const ServeOptions& options)
    : relay_(std::make_unique<Relay>(std::move(description), options)) {}

OwnLoop::~OwnLoop() { relay_->leave(); }

void OwnLoop::initialize(LinkOutput output, std::vector<double> record) {
  relay_->written = std::move(output);
  relay_->recorded = std::move(record);
  relay_->start();
}

const Setup& OwnLoop::setup() const { return relay_->setup; }

void OwnLoop::progress(std::string_view doing, double share_done) {
  if (!relay_->setting_up) throw ConfigError("progress is told between initialize and the first turn of the time loop");
  if (relay_->setup.progress) relay_->setup.progress(doing, share_done);
}

OwnLoop::Relay& OwnLoop::ready() const {
  relay_->end_setup();
  return *relay_;
}

Integration OwnLoop::integration() const { return ready().integration; }
bool OwnLoop::ongoing() const { return !ready().over; }
double OwnLoop::max_time_step() const { return ready().time_step; }
bool OwnLoop::must_save() const { return ready().save; }
bool OwnLoop::must_restore() const { return ready().restore && ongoing(); }
const std::vector<double>& OwnLoop::read() const { return ready().input; }

void OwnLoop::write(const LinkOutput& output, const std::vector<double>& record) {
  relay_->written = output;
  relay_->recorded = record;
}

void OwnLoop::advance() { ready().resume(); }

int OwnLoop::finalize() {
  relay_->leave();
  return relay_->exit_code;
}

}  // namespace ricochet::participant
