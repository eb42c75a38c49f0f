#include "musher/base/scheduling.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport::scheduling_test {

// A child that does `work`, and nothing after it until it is killed.
class Child {
 public:
  explicit Child(const std::function<void()>& work) : pid_(fork()) {
    if (pid_ != 0) return;
    work();
    while (true) pause();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    Kill();
    waitpid(pid_, nullptr, 0);
  }

  void Kill() const { kill(pid_, SIGKILL); }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
};

[[noreturn]] void ComputeForEver() {
  volatile unsigned long sum = 0;
  while (true) sum = sum + 1;
}

class Scheduling : public ::testing::Test {
 protected:
  // Whether it comes to hold.
  bool Eventually(const std::function<bool()>& condition) {
    const LoopHandlePtr tick = loop_.Every(Milliseconds(2), [] {});
    return loop_.RunUntil(condition, loop_.Now() + std::chrono::seconds(120));
  }
  bool BecomesState(pid_t pid, ProcessRunState state) {
    return Eventually([&] { return RunStateOf(pid) == state; });
  }
  ProcessSample Look(pid_t pid) {
    const auto sample = SampleProcess(pid, loop_.Now());
    EXPECT_TRUE(sample);
    return sample.value_or(ProcessSample{});
  }

  LinuxEventLoop loop_;
};

constexpr Duration kLongestDisk = Milliseconds(10'000);

Time At(int ms) {
  return Time() + Milliseconds(ms);
}
ThreadSample Thread(int ran_ms, int waited_ms, bool runnable) {
  return {{Milliseconds(ran_ms), Milliseconds(waited_ms)}, runnable};
}

TEST_F(Scheduling, DistinguishesAStoppedProcessFromARunningOne) {
  const Child child([] {});
  EXPECT_TRUE(BecomesState(child.pid(), ProcessRunState::kRunning));
  kill(child.pid(), SIGSTOP);
  EXPECT_TRUE(BecomesState(child.pid(), ProcessRunState::kStopped));
  kill(child.pid(), SIGCONT);
  EXPECT_TRUE(BecomesState(child.pid(), ProcessRunState::kRunning));
}

TEST_F(Scheduling, ReportsAProcessStoppedWhenAllItsThreadsAre) {
  const Child child([] {
    for (int i = 0; i < 3; ++i) std::thread(pause).detach();
  });
  ASSERT_TRUE(Eventually([&] {
    const auto sample = SampleProcess(child.pid(), loop_.Now());
    return sample && sample->threads.size() >= 4;
  }));
  EXPECT_EQ(RunStateOf(child.pid()), ProcessRunState::kRunning);
  kill(child.pid(), SIGSTOP);
  EXPECT_TRUE(BecomesState(child.pid(), ProcessRunState::kStopped));
}

TEST_F(Scheduling, ReadsTheStateBehindAnyName) {
  const Child child([] {
    prctl(PR_SET_NAME, "a) T (b) Z ");
    raise(SIGSTOP);
    ComputeForEver();
  });
  ASSERT_TRUE(BecomesState(child.pid(), ProcessRunState::kStopped));
  kill(child.pid(), SIGCONT);
  EXPECT_TRUE(BecomesState(child.pid(), ProcessRunState::kRunning));
}

TEST_F(Scheduling, ReportsAnExitedProcessBeforeAndAfterItIsReaped) {
  pid_t pid = 0;
  {
    const Child child([] {});
    pid = child.pid();
    child.Kill();
    EXPECT_TRUE(BecomesState(pid, ProcessRunState::kExited));
    EXPECT_EQ(SampleProcess(pid, loop_.Now()), std::nullopt);
  }
  EXPECT_EQ(RunStateOf(pid), ProcessRunState::kExited);
  EXPECT_EQ(SampleProcess(pid, loop_.Now()), std::nullopt);
  EXPECT_EQ(ThreadCpuTime(pid, pid), std::nullopt);
}

TEST_F(Scheduling, RefusesAThreadOfAnotherProcess) {
  const Child child([] {});
  EXPECT_TRUE(ThreadCpuTime(child.pid(), child.pid()));
  EXPECT_EQ(ThreadCpuTime(child.pid(), getpid()), std::nullopt);
}

TEST_F(Scheduling, CountsTheTimeAThreadRan) {
  const Child busy(ComputeForEver);
  const Child idle([] {});
  EXPECT_TRUE(Eventually([&] {
    const auto cpu = ThreadCpuTime(busy.pid(), busy.pid());
    return cpu && cpu->ran > Milliseconds(50);
  }));
  const auto cpu = ThreadCpuTime(idle.pid(), idle.pid());
  ASSERT_TRUE(cpu);
  EXPECT_LT(cpu->ran, Milliseconds(50));
}

// Four share one CPU, so each waits three quarters of the time; a fifth has nothing to do.
TEST_F(Scheduling, DistinguishesAStarvedProcessFromAHungOne) {
  const auto pinned = [cpu = sched_getcpu()] {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof(one), &one);
  };
  const auto compete = [&] {
    pinned();
    ComputeForEver();
  };
  const Child starved(compete);
  const std::array<Child, 3> others{Child(compete), Child(compete), Child(compete)};
  const Child hung(pinned);
  ASSERT_TRUE(Eventually([&] {
    return !Look(hung.pid()).threads.at(hung.pid()).runnable &&
           std::all_of(others.begin(), others.end(), [](const Child& other) {
             const auto cpu = ThreadCpuTime(other.pid(), other.pid());
             return cpu && cpu->ran > Milliseconds(20);
           });
  }));
  const ProcessSample starved_before = Look(starved.pid());
  const ProcessSample hung_before = Look(hung.pid());
  ProcessSample starved_after;
  Duration between{};
  // A wait is counted at its end: a look in the middle of a long one sees little of it.
  EXPECT_TRUE(Eventually([&] {
    starved_after = Look(starved.pid());
    between = starved_after.at - starved_before.at;
    return between > Milliseconds(300) && LongestWait(starved_before, starved_after) > between / 3;
  })) << LongestWait(starved_before, starved_after).count()
      << " of " << between.count() << " ns";
  EXPECT_LE(LongestWait(starved_before, starved_after), between);
  EXPECT_LT(LongestWait(hung_before, Look(hung.pid())), between / 10);
}

// A cgroup with a hundredth of a CPU, where the kernel and our rights allow one.
class SmallQuota {
 public:
  SmallQuota() {
    const std::string name = "/musher_test_" + std::to_string(getpid());
    for (const std::string base : {"/sys/fs/cgroup/cpu", "/sys/fs/cgroup"}) {
      folder_ = base + name;
      if (mkdir(folder_.c_str(), 0700) != 0) continue;
      if (Write("cpu.max", "1000 100000") ||
          (Write("cpu.cfs_period_us", "100000") && Write("cpu.cfs_quota_us", "1000"))) {
        return;
      }
      rmdir(folder_.c_str());
    }
    folder_.clear();
  }
  ~SmallQuota() {
    if (!folder_.empty()) rmdir(folder_.c_str());
  }
  SmallQuota(const SmallQuota&) = delete;
  SmallQuota& operator=(const SmallQuota&) = delete;

  bool Take(pid_t pid) const {
    return !folder_.empty() && Write("cgroup.procs", std::to_string(pid));
  }

 private:
  bool Write(const std::string& file, const std::string& text) const {
    std::ofstream out(folder_ + "/" + file, std::ios::in);  // it has to be there
    return static_cast<bool>(out << text << std::flush);
  }

  std::string folder_;
};

TEST_F(Scheduling, DistinguishesAThrottledProcessFromAHungOne) {
  const SmallQuota quota;
  std::optional<Child> throttled(ComputeForEver);
  if (!quota.Take(throttled->pid())) GTEST_SKIP() << "no cgroup with a CPU quota can be made here";
  const ProcessSample before = Look(throttled->pid());
  EXPECT_TRUE(
      Eventually([&] { return LongestWait(before, Look(throttled->pid())) > Milliseconds(300); }));
  throttled.reset();  // so that its cgroup is empty
}

TEST(Waiting, IsWhatAQuotaHasTaken) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, false)}}, Milliseconds(50)};
  const ProcessSample after{At(1000), {{7, Thread(20, 200, false)}}, Milliseconds(850)};
  EXPECT_EQ(ThreadWait(before, after, 7), Milliseconds(800));
}

TEST(Waiting, IsTheDifferenceOfTwoLooks) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, false)}}};
  const ProcessSample after{At(1000), {{7, Thread(20, 400, false)}}};
  EXPECT_EQ(ThreadWait(before, after, 7), Milliseconds(300));
  EXPECT_EQ(ThreadWait(before, after, 8), std::nullopt);
}

TEST(Waiting, IsAllOfTheTimeForAThreadThatWasReadyAndDidNotRun) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, true)}}};
  const ProcessSample after{At(1000), {{7, Thread(10, 100, true)}}};
  EXPECT_EQ(ThreadWait(before, after, 7), Milliseconds(1000));
}

TEST(Waiting, IsNothingForAThreadThatSleeps) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, false)}}};
  const ProcessSample after{At(1000), {{7, Thread(10, 100, false)}}};
  EXPECT_EQ(ThreadWait(before, after, 7), Duration::zero());
}

TEST(Waiting, IsNotLongerThanTheTimeBetweenTheLooks) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, true)}}};
  const ProcessSample after{At(1000), {{7, Thread(11, 6100, true)}}};
  EXPECT_EQ(ThreadWait(before, after, 7), Milliseconds(999)) << "the rest was before";
}

// On two CPUs a quota takes more than there is time: a process that computes for ever was never
// detected as hung.
TEST(Waiting, IsNotTheTimeInWhichItRanHoweverMuchAQuotaHasTaken) {
  const ProcessSample before{At(0), {{7, Thread(10, 100, true)}}, Milliseconds(0)};
  const ProcessSample after{At(1000), {{7, Thread(410, 200, true)}}, Milliseconds(1200)};
  EXPECT_EQ(ThreadWait(before, after, 7), Milliseconds(600));
}

TEST(Waiting, IsThatOfTheWorstOffThread) {
  const ProcessSample before{At(0), {{7, Thread(0, 0, false)}, {8, Thread(0, 0, false)}}};
  const ProcessSample after{
      At(1000), {{7, Thread(1, 200, false)}, {8, Thread(5, 700, true)}, {9, Thread(1, 300, true)}}};
  EXPECT_EQ(LongestWait(before, after), Milliseconds(700));
  EXPECT_EQ(LongestWait(before, {At(1000), {}}), Duration::zero());
}

// On a host without a CPU to spare an actuator was killed as hung: its heartbeat had waited in its
// own process, and then in the controller, and only the longer of the two waits was subtracted.
TEST(Waiting, OfAMessageIsThatOfItsSenderAndThenThatOfItsReceiver) {
  const ProcessSamples sender{{At(0), {{7, Thread(0, 0, false)}}},
                              {At(1000), {{7, Thread(1, 400, false)}}}};
  const ProcessSamples receiver{{At(0), {{9, Thread(0, 0, false)}}},
                                {At(1000), {{9, Thread(1, 500, false)}}}};
  EXPECT_EQ(LongestWaitOfBoth(sender, receiver, 9, kLongestDisk), (Wait{Milliseconds(900), {}}));
  const ProcessSamples late{{At(0), {{9, Thread(0, 0, false)}}},
                            {At(1000), {{9, Thread(1, 900, false)}}}};
  EXPECT_EQ(LongestWaitOfBoth(sender, late, 9, kLongestDisk), (Wait{Milliseconds(1000), {}}))
      << "no more than there was time";
}

// A thread that is blocked, or not; with its pages from the disk, and the kernel's count of its
// waits.
ThreadSample OnDisk(int ran_ms, int waited_ms, bool blocked, std::uint64_t faults = 0,
                    int counted_ms = 0) {
  return {{Milliseconds(ran_ms), Milliseconds(waited_ms)},
          false,
          blocked,
          faults,
          Milliseconds(counted_ms)};
}
ProcessSample SampleAt(int ms, const ThreadSample& thread, std::optional<int> pressure_ms) {
  ProcessSample sample{At(ms), {{7, thread}}, {}, std::nullopt};
  if (pressure_ms) sample.disk_pressure = Milliseconds(*pressure_ms);
  return sample;
}

TEST(WaitingForTheDisk, IsWhatTheKernelCountsOfAThread) {
  const auto before = SampleAt(0, OnDisk(10, 0, false, 3, 50), 5000);
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(20, 0, false, 3, 750), 5700), 7),
            Milliseconds(700));
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(510, 0, false, 3, 750), 5700), 7),
            Milliseconds(500))
      << "no more than the time in which it did not run";
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(20, 0, false), 5700), 8), std::nullopt);
}

TEST(WaitingForTheDisk, IsAtMostThatOfTheHostForAThreadThatIsBlockedOrHasReadPages) {
  const auto quiet = SampleAt(0, OnDisk(10, 0, false, 3), 5000);
  const auto blocked = SampleAt(0, OnDisk(10, 0, true, 3), 5000);
  EXPECT_EQ(ThreadDiskWait(quiet, SampleAt(1000, OnDisk(10, 0, true, 3), 5600), 7),
            Milliseconds(600));
  EXPECT_EQ(ThreadDiskWait(blocked, SampleAt(1000, OnDisk(10, 0, false, 3), 5600), 7),
            Milliseconds(600));
  EXPECT_EQ(ThreadDiskWait(quiet, SampleAt(1000, OnDisk(10, 0, false, 4), 5600), 7),
            Milliseconds(600));
}

// The total since the boot was multiplied by the CPUs that are online now: with one more of them, a
// blocked thread had waited for all of the time.
TEST(WaitingForTheDisk, IsNotLongerBecauseACpuHasComeOnline) {
  auto before = SampleAt(0, OnDisk(10, 0, true), 50'000);
  auto after = SampleAt(10'000, OnDisk(10, 0, true), 50'600);
  before.cpus = 2;
  after.cpus = 3;
  EXPECT_EQ(ThreadDiskWait(before, after, 7), Milliseconds(1800));
  std::swap(before.cpus, after.cpus);
  EXPECT_EQ(ThreadDiskWait(before, after, 7), Milliseconds(1800));
}

TEST(WaitingForTheDisk, IsNothingForAThreadThatSleepsBesideABusyDisk) {
  const auto before = SampleAt(0, OnDisk(10, 0, false, 3), 5000);
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(10, 0, false, 3), 6000), 7),
            Duration::zero());
}

// Of a camera, say: the disk has nothing to do with it.
TEST(WaitingForTheDisk, IsNothingForAThreadThatIsBlockedInADriverBesideAnIdleDisk) {
  const auto before = SampleAt(0, OnDisk(10, 0, true), 5000);
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(10, 0, true), 5000), 7), Duration::zero());
}

TEST(WaitingForTheDisk, IsAllTheTimeOfABlockedThreadWhereTheKernelCountsNothing) {
  const auto before = SampleAt(0, OnDisk(10, 0, true), std::nullopt);
  EXPECT_EQ(ThreadDiskWait(before, SampleAt(1000, OnDisk(30, 0, true), std::nullopt), 7),
            Milliseconds(980));
}

TEST(WaitingForTheDisk, AndForACpuAreNoMoreThanTheTimeInWhichItDidNotRun) {
  const ProcessSamples samples{SampleAt(0, OnDisk(10, 0, true), 5000),
                               SampleAt(1000, OnDisk(30, 742, true), 6000)};
  EXPECT_EQ(WaitOfThread(samples, 7), (Wait{Milliseconds(742), Milliseconds(238)}));
}

// The controller's journal writes to the disk all the time, and delays no message.
TEST(WaitingForTheDisk, OfTheReceiverIsThatOfTheThreadThatReceives) {
  const ProcessSamples sender{SampleAt(0, OnDisk(0, 0, true), 0),
                              SampleAt(1000, OnDisk(0, 100, true), 500)};
  ProcessSamples receiver{SampleAt(0, OnDisk(0, 0, true), 0),
                          SampleAt(1000, OnDisk(0, 0, true), 500)};
  EXPECT_EQ(LongestWaitOfBoth(sender, receiver, 9, kLongestDisk),
            (Wait{Milliseconds(100), Milliseconds(500)}));
  for (ProcessSample* one : {&receiver.before, &receiver.after})
    one->threads[9] = OnDisk(0, 0, true);
  EXPECT_EQ(LongestWaitOfBoth(sender, receiver, 9, kLongestDisk),
            (Wait{Milliseconds(100), Milliseconds(900)}))
      << "no more than there was time";
}

// A thread that got no CPU sends the heartbeats, and another one writes a log: the wait of the log
// was taken, of which too little counts, and the actuator was killed as hung.
TEST(WaitingForTheDisk, OfALogDoesNotHideThatAnotherThreadGotNoCpu) {
  ProcessSamples sender{SampleAt(0, OnDisk(0, 0, true), std::nullopt),
                        SampleAt(12'000, OnDisk(0, 0, true), std::nullopt)};
  sender.before.threads[8] = Thread(0, 0, true);
  sender.after.threads[8] = Thread(100, 11'900, true);
  const ProcessSamples receiver{SampleAt(0, {}, std::nullopt), SampleAt(12'000, {}, std::nullopt)};
  EXPECT_EQ(LongestWaitOfBoth(sender, receiver, 7, kLongestDisk), (Wait{Milliseconds(11'900), {}}));
}

// The parent of vfork() is blocked until its child ends, and no disk takes part in it.
TEST_F(Scheduling, SeesThatAThreadIsBlocked) {
  int returned[2];  // readable once vfork() has returned to the parent although its child runs
  ASSERT_EQ(pipe2(returned, O_CLOEXEC | O_NONBLOCK), 0);
  const UniqueFd read_end(returned[0]);
  const UniqueFd write_end(returned[1]);
  const Child child([&] {
    const pid_t parent = getpid();
    if (vfork() == 0) {  // NOLINT(clang-analyzer-security.insecureAPI.vfork)
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      while (getppid() == parent) pause();  // it may have been killed before
      _exit(0);
    }
    (void)!write(write_end.get(), "r", 1);
    pause();
  });
  bool is_fork = false;
  EXPECT_TRUE(Eventually([&] {
    char byte = 0;
    is_fork = read(read_end.get(), &byte, 1) == 1;
    const auto sample = Look(child.pid());
    const auto thread = sample.threads.find(child.pid());
    return is_fork || (thread != sample.threads.end() && thread->second.blocked);
  }));
  if (is_fork) GTEST_SKIP() << "vfork() is a fork() here, as under qemu-user";
}

TEST_F(Scheduling, CountsThePagesThatWereReadFromTheDiskAndThePressureOfTheHost) {
  const auto sample = Look(getpid());
  struct rusage used {};
  ASSERT_EQ(getrusage(RUSAGE_THREAD, &used), 0);
  EXPECT_LE(sample.threads.at(getpid()).disk_faults, static_cast<std::uint64_t>(used.ru_majflt));
  const auto pressure = DiskPressure();
  if (!pressure) GTEST_SKIP() << "this kernel has no /proc/pressure/io";
  EXPECT_GE(*pressure, Duration::zero());
  EXPECT_EQ(sample.disk_pressure.has_value(), true);
}

}  // namespace musher::transport::scheduling_test
