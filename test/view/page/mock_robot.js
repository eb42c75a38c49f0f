// A scripted robot for the tests of the page: it has the messages of a machine, and changes them as a test
// says. `emit(message)` receives what the server would send to every page.

const STATES = ['Active', 'DeActive', 'Protected', 'LowPower', 'OTA', 'Error', 'SelfCheck', 'TearDown'];
const RANKS = {TearDown: 0, Error: 1, OTA: 2, LowPower: 3, DeActive: 4, Protected: 5, Active: 6};
const STATUS = '/musher/machine_status';
const CAPABILITIES = '/musher/capabilities';

function actuator(name, wave, critical, pid) {
  return {wave, info: {name, state: 'Active', target: '', presence: 'present', pid,
    host: '4f2c91d0/4026531836', stage: 1,
    critical, held: false, degraded: false, code: 0, message: '', health: 'well', restarts: 0,
      restarting: false,
    protocol: 'musher'}};
}

export class MockRobot {
  constructor(emit = () => {}, startMs = Date.now()) {
    this.emit = emit;
    this.nowMs = () => Date.now();
    this.parts = [actuator('world', 1, true, 4101), actuator('motion_manager', 2, true, 4102),
      actuator('audio', 1, false, 4103), actuator('device_manager', 1, true, 4104),
      actuator('sensor_manager', 1, true, 4105), actuator('camera', 2, false, 4106),
        actuator('wedding', 3, false, 4107),
      actuator('gardener', 3, false, 4108), actuator('skills', 3, false, 4109)];
    this.machineId = '5982c7ee-4c0e-4a5f-9d58-2f1f2f2a7b11';
    this.state = 'Active';
    this.target = '';
    this.epoch = 7;
    this.switchNumber = 3;
    this.stop = null;
    this.stopIds = [];
    this.policy = {active: true, battery: 76, charging: false, battery_silent: false, ceiling: '',
      ceiling_reason: '',
      kept: '', keep_s: 0, low_power_switch: true, power: ''};
    this.violatedRules = [];
    this.notStopped = [];
    this.history = [];
    this.nextId = 1;
    this.present = true;
    this.behavior = 'WATCH';
    this.treeStatus = [1, 2, 1, 2, 1, 0, 0];
    this.progress = 40;
    this.skillStatus = 0;
    this.skillPaused = false;
    this.skillGoal = '00';
    this.large = false;
    this.pastDay(startMs);
  }

  pastDay(now) {
    const at = s => now - s * 1000;
    const started = this.record('controller_started', 'controller started: epoch 7, 9 actuators',
      {ms: at(900), kind: 'controller'});
    for (const {info} of this.parts) {
      this.record('process_started', `${info.name} started (pid ${info.pid})`,
        {ms: at(899.8), actuator: info.name, cause: started});
      this.record('actuator_present', `${info.name} is present in SetUp (pid ${info.pid})`,
        {ms: at(898), actuator: info.name, cause: started});
    }
    const check = this.record('actuators_set_up', '9 actuators are set up',
      {ms: at(897), cause: started, state: 'SelfCheck'});
    for (const {info} of this.parts) {
      this.record('command_done', `${info.name}: Active done after 34 ms`,
        {ms: at(895 - this.parts.indexOf(this.part(info.name)) * 0.1), actuator: info.name, cause: check});
    }
    this.record('machine_usable', 'the machine is usable in Active',
      {ms: at(894), cause: check, state: 'Active'});
    const request = this.record('switch_requested', 'switch to LowPower requested by alice at desk',
      {ms: at(620), kind: 'switch'});
    const down = this.record('switch_started', 'switch 2: Active → LowPower, 9 actuators',
      {ms: at(619.9), cause: request, kind: 'switch'});
    for (const {info} of this.parts) this.record('command_done', `${info.name}: LowPower done after 210 ms`,
      {ms: at(619.5), actuator: info.name, cause: down});
    this.record('switch_done', 'switch 2 is done', {ms: at(619.4), cause: down, state: 'LowPower',
      kind: 'switch'});
    const wake = this.record('policy_requested', 'wake-up requested by the touch pad',
      {ms: at(360), kind: 'policy'});
    const up = this.record('switch_started', 'switch 3: LowPower → Active, 9 actuators',
      {ms: at(359.9), cause: wake, kind: 'switch'});
    for (const {info} of this.parts) this.record('command_done', `${info.name}: Active done after 480 ms`,
      {ms: at(359), actuator: info.name, cause: up});
    this.record('switch_done', 'switch 3 is done', {ms: at(358.9), cause: up, state: 'Active',
      kind: 'switch'});
    const crash = this.record('actuator_crashed',
      'audio is degraded: crashed: its process 4093 was ended by SIGSEGV',
      {ms: at(140), actuator: 'audio', code: 1105, kind: 'actuator',
      data: '#0  0x00007f1e2c Player::Fill()\n#1  0x00007f1e88 Player::Run()'});
    const again = this.record('restart_scheduled', 'audio: restarting in 100 ms (1 of 5)',
      {ms: at(139.9), actuator: 'audio', cause: crash, kind: 'process'});
    this.record('process_started', 'audio started (pid 4103)',
      {ms: at(139.8), actuator: 'audio', cause: again});
    this.record('command_done', 'audio: Active done after 61 ms',
      {ms: at(138.6), actuator: 'audio', cause: again});
  }

  part(name) {
    return this.parts.find(p => p.info.name === name);
  }

  record(event, message, {ms = this.nowMs(), kind = 'actuator', actuator: name = '', code = 0, cause = 0,
    state = '', data = ''} = {}) {
    const entry = {id: this.nextId++, wall_ns: `${Math.round(ms * 1000)}000`, epoch: this.epoch,
      switch_number: this.switchNumber,
      kind, actuator: name, code, message, cause, state, data, event};
    this.history.push(entry);
    this.emit({op: 'history', reset: false, entries: [entry]});
    return entry.id;
  }

  status() {
    const degraded = this.parts.filter(p => p.info.degraded).map(p => p.info.name);
    return {machine: 'robot', machine_id: this.machineId, name_space: '', phase: 'running', state: this.state, target: this.target,
      epoch: this.epoch,
      switch_number: this.switchNumber, pid: 4090, host: 'robot-7', config_file: '/etc/musher/robot.toml',
        config_hash: '5d41402a',
      emergency_stop: this.stop !== null, emergency_stop_by: this.stop?.by ?? '',
        emergency_stop_reason: this.stop?.reason ?? '', stop_ids: [...this.stopIds],
      degraded, actuators: this.parts.map(p => ({...p.info})), policy: {...this.policy}, not_on_disk: [],
        held_by_stop: [], violated_rules: [...this.violatedRules], not_stopped: [...this.notStopped]};
  }

  capabilities() {
    const one = (name, description, actuators, states) => {
      const bad = actuators.map(n => this.part(n).info).find(a => a.degraded);
      const wrong = !states.includes(this.state);
      return {name, description, actuators, states, allowed: !bad && !wrong, code: bad || wrong ? 103 : 0,
        reason: wrong ? `the machine is in ${this.state}; ${name} needs ${states.join(' or ')}`
          : bad ? `${bad.name} is degraded: ${bad.message}` : ''};
    };
    return {capabilities: [one('walk', 'walk, by a stream of velocities', ['motion_manager'], ['Active']),
      one('stand', 'stand up', ['motion_manager'], ['Active', 'Protected']),
      one('speak', 'say a sentence', ['audio'], ['Active', 'Protected']),
      one('camera', 'take pictures', ['camera'], ['Active', 'Protected', 'DeActive'])]};
  }

  latest(topic, type, message) {
    return {op: 'latest', topic, type, received_ms: this.nowMs(), message};
  }

  publish() {
    if (!this.present) return;
    this.emit(this.latest(STATUS, 'musher_msgs/msg/MachineStatus', this.status()));
    this.emit(this.latest(CAPABILITIES, 'musher_msgs/msg/Capabilities', this.capabilities()));
  }

  // What a page gets when it connects.
  greeting() {
    const list = [{op: 'topics', topics: this.topics()}, {op: 'history', reset: true, entries: this.history},
      this.processes()];
    list.push(this.latest(STATUS, 'musher_msgs/msg/MachineStatus', this.status()));
    list.push(this.latest(CAPABILITIES, 'musher_msgs/msg/Capabilities', this.capabilities()));
    if (!this.present) list.push({op: 'gone', topic: STATUS}, {op: 'gone', topic: CAPABILITIES});
    return list;
  }

  topics() {
    const topic = (name, type) => ({name, type, publishers: 1, subscribers: 0});
    return [topic(STATUS, 'musher_msgs/msg/MachineStatus'), topic('/image_rgb', 'sensor_msgs/msg/Image'),
      topic('/image_left', 'sensor_msgs/msg/Image'), topic('/wedding/behavior_state', 'std_msgs/msg/String'),
      topic('/gardener/tree_state', 'musher_msgs/msg/TreeState'),
        topic('/skills', 'musher_msgs/msg/SkillOffers'),
      topic('/skill_feedback', 'musher_msgs/msg/SkillFeedback')];
  }

  processes() {
    return {op: 'processes', actuators: this.parts.filter(p => p.info.pid).map((p,
      i) => ({name: p.info.name, pid: p.info.pid,
      cpu_percent: 1.3 + i * 2.4, rss_bytes: 21e6 + i * 9.7e6, threads: 5 + i}))};
  }

  watched(topic) {
    if (topic === '/wedding/behavior_state') return this.latest(topic, 'std_msgs/msg/String',
      {data: this.behavior});
    if (topic === '/gardener/tree_state') return this.latest(topic, 'musher_msgs/msg/TreeState',
      this.tree().state);
    if (topic === '/skills') {
      return this.latest(topic, 'musher_msgs/msg/SkillOffers',
        {actuator: 'skills', action: '/skill_execution',
        skills: [{skill: 'goto', summary: 'drives to a place of the map',
          parameters: ['x_m: number', 'y_m: number']},
          {skill: 'take_photo', summary: 'takes a picture and stores it',
            parameters: ['name: text, required', 'delay_s: number, default 0, 0 to 10']}]});
    }
    if (topic === '/skill_feedback') {
      return this.latest(topic, 'musher_msgs/msg/SkillFeedback',
        {header: {}, actuator: 'skills', skill: 'goto', goal_id: this.skillGoal, status: this.skillStatus,
        state: 'MOVING', progress: this.progress, message: 'Driving to the goal',
          details: [{key: 'distance_to_goal_m', value: '1.25'},
            ...(this.skillPaused ? [{key: 'paused', value: 'by a request'}] : [])]});
    }
    return null;
  }

  // A machine of many states, as a race has: each leads to the next one and back to the start.
  largeBehavior() {
    const states = Array.from({length: 40}, (_, i) => `SECTION_${i}`);
    const arrows = states.flatMap((_, i) => [[i, (i + 1) % 40, 'the line is passed'],
      [i, (i + 1) % 40, 'the time is over'], [i, 0, 'lost']]);
    return ['stateDiagram-v2', ...states.map((s, i) => `  state "${s}" as s${i}`), '  [*] --> s0',
      ...arrows.map(([a, b, why]) => `  s${a} --> s${b} : ${why}`)].join('\n');
  }

  behaviorReport() {
    const states = ['WAIT', 'WATCH', 'PHOTO', 'SPEAK', 'DONE', 'SAFE'];
    const arrows = [['WAIT', 'WATCH', 'the guests are seen'], ['WATCH', 'PHOTO', 'they stand still'],
      ['PHOTO', 'SPEAK', 'the picture is stored'],
      ['SPEAK', 'WATCH', 'more guests'], ['SPEAK', 'DONE', 'all are photographed'],
        ['WATCH', 'WAIT', 'no person is seen for 10 s'], ['PHOTO', 'WATCH', 'blurred']];
    const id = name => `s${states.indexOf(name)}`;
    const graph = ['stateDiagram-v2', ...states.map(s => `  state "${s}" as ${id(s)}`), '  [*] --> s0',
      ...arrows.map(([a, b, why]) => `  ${id(a)} --> ${id(b)} : ${why}`), '  s4 --> [*]', '  class s5 safe',
        `  class ${id(this.behavior)} present`];
    return {error: '', running: true, ticking: true, current_state: this.behavior, operating_mode: 'NORMAL',
      iter_count: 4711, safety_triggered: false,
      unsafe: '', time_s: 235.5, time_in_state_s: 4.2, last_fault: '', graph: this.large ? this.largeBehavior() : `${graph.join('\n')}\n`,
        held_by_stop: false, commands: ['stop'],
      history: [{time_s: 0, tick: 0, from: '', to: 'WAIT', cause: 'started', command: ''},
        {time_s: 12, tick: 240, from: 'WAIT', to: 'WATCH', cause: 'decided', command: ''}]};
  }

  tree() {
    const node = (name, type, kind, parent) => ({name, type, kind, parent, file: 'garden.xml', line: 4,
      spent_s: 12.5, runs: 3});
    return {error: '', state: {tree: 'Garden', revision: 1, ticking: true, ticks: 900, time_s: 45,
      status: this.treeStatus, last_fault: ''},
      nodes: [node('Garden', 'Sequence', 'Control', -1), node('is_dry', 'SoilIsDry', 'Condition', 0),
        node('each_bed', 'Repeat', 'Decorator', 0),
        node('water', 'Sequence', 'Control', 2), node('drive', 'GoTo', 'Action', 3),
          node('open_valve', 'SetValve', 'Action', 3), node('Home', 'GoHome', 'SubTree', 0)].map((n,
          i) => (i === 3 ? {...n, parent: 2} : n)),
      entries: [], history: [], graph: ''};
  }

  plan({target, actuator: name}) {
    const answer = {target, actuator: name ?? '', allowed: true, code: 0, reason: '', direction: 'level',
      state: this.state, steps: []};
    if (!STATES.includes(target)) return {...answer, allowed: false, code: 102,
      reason: `this machine has no state '${target}'`};
    const up = (RANKS[target] ?? 9) > (RANKS[this.state] ?? 0);
    answer.direction = target === 'SelfCheck' ? 'check' : up ? 'up' : RANKS[target] < RANKS[this.state]
      ? 'down' : 'level';
    if (this.stop && up) return {...answer, allowed: false, code: 113,
      reason: `an emergency stop is engaged by ${this.stop.by}: ${this.stop.reason}; release it first`};
    if (this.state === 'Error' && target === 'Active') return {...answer, allowed: false, code: 103,
      reason: 'from Error the machine goes to SelfCheck first'};
    for (const p of name ? [this.part(name)] : this.parts) {
      const there = p.info.state === target || p.info.presence !== 'present';
      answer.steps.push({name: p.info.name, wave: there ? 0 : p.wave, from: p.info.state, to: target,
        deadline_ms: 5000,
        note: p.info.presence !== 'present' ? 'it is lost' : there ? 'it is there already' : ''});
    }
    return answer;
  }

  // One leg at a time as `wait` allows it: the test decides when.
  async set({target, actuator: name}, wait, by) {
    const plan = this.plan({target, actuator: name});
    const answer = {switch_number: ++this.switchNumber, target, actuator: name, outcome: 'done', code: 0,
      reason: '', state: this.state, degraded: [], actuators: []};
    const request = this.record('switch_requested', `switch to ${target} requested by ${by}`,
      {kind: 'switch'});
    if (!plan.allowed) {
      this.record('switch_refused', `switch to ${target} refused: ${plan.reason}`,
        {kind: 'switch', code: plan.code, cause: request});
      return {...answer, outcome: 'refused', code: plan.code, reason: plan.reason};
    }
    const started = this.record('switch_started',
      `switch ${this.switchNumber}: ${this.state} → ${target}, ${plan.steps.length} actuators`,
      {kind: 'switch', cause: request});
    this.target = target;
    for (const wave of [1, 2, 3]) {
      const steps = plan.steps.filter(s => s.wave === wave);
      if (steps.length === 0) continue;
      for (const step of steps) this.part(step.name).info.target = target;
      this.publish();
      await wait(wave);
      for (const step of steps) {
        Object.assign(this.part(step.name).info, {state: target, target: ''});
        answer.actuators.push({name: step.name, outcome: 'done', code: 0, message: '', duration_ms: 120.5,
          state: target});
        this.record('command_done', `${step.name}: ${target} done after 120 ms`,
          {actuator: step.name, cause: started});
      }
    }
    this.target = '';
    if (!name) this.state = target;
    this.record('switch_done', `switch ${this.switchNumber} is done`,
      {kind: 'switch', cause: started, state: name ? '' : target});
    this.publish();
    return {...answer, state: this.state};
  }

  fault(name, {health = 'crashed', message = 'crashed: its process was ended by SIGSEGV; restarting',
    restarting = false} = {}) {
    const info = this.part(name).info;
    const lost = this.record('process_exited', `${name}'s process ${info.pid} was ended by SIGSEGV`,
      {actuator: name, kind: 'process'});
    this.record('actuator_crashed', `${name} is degraded: ${message}`,
      {actuator: name, code: 1105, cause: lost});
    Object.assign(info, {health, presence: health === 'crashed' ? 'lost' : 'present', degraded: true,
      code: 1105, message, restarting, pid: health === 'crashed' ? 0 : info.pid});
    this.publish();
    this.emit(this.processes());
  }

  recover(name) {
    Object.assign(this.part(name).info, {health: 'well', presence: 'present', degraded: false, code: 0,
      message: '', restarting: false,
      pid: 5201, restarts: 1, state: this.state});
    this.record('process_started', `${name} started (pid 5201)`, {actuator: name, kind: 'process'});
    this.record('command_done', `${name}: ${this.state} done after 80 ms`, {actuator: name});
    this.publish();
    this.emit(this.processes());
  }

  engage(by, reason) {
    this.stop ??= {by, reason};
    this.stopIds.push((0xa1 + this.stopIds.length).toString(16).padStart(16, '0'));
    this.record('emergency_stop_engaged', `emergency stop engaged by ${by}: ${reason}`, {kind: 'controller'});
    this.publish();
  }

  release(by) {
    this.stop = null;
    this.stopIds = [];
    this.record('emergency_stop_released', `emergency stops released by ${by}`, {kind: 'controller'});
    this.publish();
  }

  controllerEnds() {
    this.present = false;
    this.emit({op: 'gone', topic: STATUS});
    this.emit({op: 'gone', topic: CAPABILITIES});
  }

  controllerReturns() {
    this.present = true;
    ++this.epoch;
    this.record('machine_adopted', 'the machine is adopted in Active',
      {kind: 'controller', state: this.state});
    this.publish();
  }
}
