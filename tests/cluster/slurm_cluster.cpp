#include "tests/cluster/slurm_cluster.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <stdexcept>
#include <thread>

#include "tests/support/process_table.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
const std::array<std::string, 3> daemons = {"/usr/sbin/munged", "/usr/sbin/slurmctld", "/usr/sbin/slurmd"};

/// Ports that nobody listens at now.
std::vector<int> free_ports(int count) {
  std::vector<int> sockets, ports;
  for (int i = 0; i < count; ++i) {
    sockets.push_back(socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), size) != 0) throw std::runtime_error("bind failed");
    getsockname(sockets.back(), reinterpret_cast<sockaddr*>(&address), &size);
    ports.push_back(ntohs(address.sin_port));
  }
  for (const int one : sockets) close(one);
  return ports;
}

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

std::string environment_of(pid_t pid) { return '\0' + proc_text(fmt::format("/proc/{}/environ", pid)); }

bool has_variable(pid_t pid, const std::string& assignment) {
  return environment_of(pid).find('\0' + assignment + '\0') != std::string::npos;
}

}  // namespace

std::string SlurmCluster::obstacle() {
  if (geteuid() != 0) return "a Slurm of one's own needs root";
  for (const auto& program : daemons) {
    if (access(program.c_str(), X_OK) != 0) return program + " is missing: apt-get install slurm-wlm munge";
  }
  return "";
}

SlurmCluster::SlurmCluster() {
  const auto in = [this](const char* name) { return (folder_.path() / name).string(); };
  for (const char* name : {"log", "state", "spool"}) fs::create_directory(in(name));
  write_configuration();
  setenv("SLURM_CONF", in("slurm.conf").c_str(), 1);
  start("munged",
        {daemons[0], "--foreground", "--force", "--key-file=" + in("munge.key"), "--socket=" + in("munge"),
         "--pid-file=" + in("munged.pid"), "--log-file=" + in("log/munged.log"), "--seed-file=" + in("seed")});
  if (!wait_until([&] { return fs::exists(in("munge")); }, 10.0)) throw std::runtime_error("no munge\n" + logs());
  start("slurmctld", {daemons[1], "-D", "-i"});
  for (int n = 1; n <= nodes; ++n) start(fmt::format("node{}", n), {daemons[2], "-D", "-N", fmt::format("node{}", n)});
  const auto idle = fmt::format("{}\n", nodes);
  if (!wait_for_answer({"sinfo", "-h", "-t", "idle", "-o", "%D"}, idle, 30.0))
    throw std::runtime_error("the nodes are not idle\n" + logs());
}

SlurmCluster::~SlurmCluster() {
  ask({"scancel", "--user=root"});
  wait_until_empty(5.0);
  for (auto one = daemons_.rbegin(); one != daemons_.rend(); ++one) {
    kill((*one)->pid(), SIGTERM);
    kill((*one)->pid(), SIGCONT);
    (*one)->wait(5.0);
  }
  // Steps of nodes that a test has killed or stopped.
  for (const pid_t pid : processes(true)) kill(pid, SIGKILL);
}

void SlurmCluster::start(const std::string& name, std::vector<std::string> command) {
  // Should this program be killed, nothing else would end them.
  command.insert(command.begin(), {"/usr/bin/setpriv", "--pdeathsig", "KILL"});
  const auto log = (folder_.path() / "log" / (name + ".out")).string();
  daemons_.push_back(std::make_unique<Process>(command, log, log));
}

void SlurmCluster::write_configuration() const {
  std::ofstream key(folder_.path() / "munge.key", std::ios::binary);
  std::random_device random;
  for (int i = 0; i < 1024; ++i) key.put(static_cast<char>(random()));
  key.close();
  fs::permissions(folder_.path() / "munge.key", fs::perms::owner_read | fs::perms::owner_write);
  const auto ports = free_ports(nodes + 1);
  const std::string folder = folder_.path().string(), host = host_name();
  // A node that does not answer is down after five seconds; a job that is queued again begins after as long.
  std::string text = fmt::format(
      "ClusterName=test\nSlurmctldHost={1}(127.0.0.1)\nSlurmctldPort={2}\nSlurmUser=root\nSlurmdUser=root\n"
      "AuthType=auth/munge\nAuthInfo=socket={0}/munge,cred_expire=5\nStateSaveLocation={0}/state\n"
      "SlurmdSpoolDir={0}/spool/%n\nTmpFS={0}/tmp/%n\nSlurmctldPidFile={0}/slurmctld.pid\nSlurmdPidFile={0}/%n.pid\n"
      "SlurmctldLogFile={0}/log/slurmctld.log\nSlurmdLogFile={0}/log/%n.log\n"
      "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
      "SelectTypeParameters=CR_CPU\nSlurmdParameters=config_overrides\nSlurmctldTimeout=10\nSlurmdTimeout=5\n"
      "KillWait=3\nOverTimeLimit=0\nReturnToService=2\nMinJobAge=600\nMpiDefault=none\nSwitchType=switch/none\n"
      "JobCompType=jobcomp/none\nAccountingStorageType=accounting_storage/none\n"
      "JobAcctGatherType=jobacct_gather/none\nSchedulerParameters=batch_sched_delay=0,sched_interval=1\n",
      folder, host, ports[0]);
  for (int n = 1; n <= nodes; ++n) {
    for (const char* of_node : {"spool", "tmp"})  // PMIx wants one of its own for a step's
      fs::create_directories(folder_.path() / of_node / fmt::format("node{}", n));
    text += fmt::format("NodeName=node{} NodeHostname={} NodeAddr=127.0.0.1 Port={} CPUs={} RealMemory=1000\n", n, host,
                        ports[static_cast<std::size_t>(n)], processors);
  }
  text += "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO\n";
  static_cast<void>(folder_.write(text, "slurm.conf"));
}

std::string SlurmCluster::logs() const {
  std::string text;
  for (const auto& entry : fs::directory_iterator(folder_.path() / "log"))
    text += entry.path().filename().string() + ":\n" + file_text(entry.path().string());
  return text;
}

std::string SlurmCluster::ask(const std::vector<std::string>& command) const {
  auto words = command;
  words.front().insert(0, "/usr/bin/");
  return run_command(words, scratch_.path().string(), 30.0).out;
}

std::string SlurmCluster::submit(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"/usr/bin/sbatch", "--parsable", "--chdir=" + folder_.path().string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const auto outcome = run_command(words, scratch_.path().string(), 30.0);
  if (outcome.code != 0) throw std::runtime_error("sbatch: " + outcome.error);
  return outcome.out.substr(0, outcome.out.find('\n'));
}

std::string SlurmCluster::state_of(const std::string& job) const {
  const auto text = ask({"scontrol", "--oneliner", "show", "job", job});
  const std::string key = "JobState=";
  const auto at = text.find(key);
  return at == std::string::npos ? "" : text.substr(at + key.size(), text.find(' ', at) - at - key.size());
}

bool SlurmCluster::wait_for_answer(const std::vector<std::string>& command, const std::string& answer,
                                   double timeout_s) const {
  const auto as_awaited = [&] {
    if (ask(command) == answer) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return false;
  };
  return wait_until(as_awaited, timeout_s);
}

bool SlurmCluster::wait_until_empty(double timeout_s) const {
  return wait_for_answer({"squeue", "--noheader"}, "", timeout_s);
}

void SlurmCluster::signal_node(const std::string& node, int signal) const {
  const auto of_node = [&](pid_t pid) {
    const std::string command = proc_text(fmt::format("/proc/{}/cmdline", pid));
    return has_variable(pid, "SLURMD_NODENAME=" + node) || command.ends_with("-N" + std::string(1, '\0') + node + '\0');
  };
  std::vector<pid_t> victims;
  for (const pid_t pid : processes(true)) {
    if (!of_node(pid)) continue;
    victims.push_back(pid);
    // The step that started it: slurmstepd has the environment of slurmd.
    const std::string stat = proc_text(fmt::format("/proc/{}/stat", pid));
    const pid_t parent = std::stoi(stat.substr(stat.rfind(") ") + 4));
    if (proc_text(fmt::format("/proc/{}/comm", parent)).starts_with("slurmstepd")) victims.push_back(parent);
  }
  for (const pid_t pid : victims) kill(pid, signal);
}

std::vector<pid_t> SlurmCluster::processes(bool also_daemons) const {
  auto found = processes_with("");
  const std::string own = "SLURM_CONF=" + (folder_.path() / "slurm.conf").string();
  std::erase_if(found, [&](pid_t pid) {
    const auto name = proc_text(fmt::format("/proc/{}/comm", pid));
    const bool daemon = name == "munged\n" || name == "slurmctld\n" || name == "slurmd\n" || name == "slurmscriptd\n";
    return !has_variable(pid, own) || (daemon && !also_daemons);
  });
  return found;
}

}  // namespace ricochet::test
