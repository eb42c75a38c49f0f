// A robot of real processes for the tests of view/: a controller, two actuators, and musher-view beside it. In
// a namespace of its own, in a DDS domain that no test in C++ takes; close() ends all of its processes.
import {execFile, spawn} from 'node:child_process';
import {once} from 'node:events';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import os from 'node:os';
import path from 'node:path';
import {createInterface} from 'node:readline';
import {fileURLToPath} from 'node:url';
import {promisify} from 'node:util';

const here = path.dirname(fileURLToPath(import.meta.url));
const BIN = process.env.MUSHER_BIN ?? path.resolve(here, '../../build/dev/bin');

const ROBOT = `
[controller]
name = "dog"
namespace = "NAMESPACE"
actuators = ["motion", "audio"]
states = ["SetUp", "SelfCheck", "Active", "DeActive", "TearDown"]
default_time = 20000
default_state = "Uninitialized"

[actuator.motion]
states = ["SetUp", "SelfCheck", "Active", "DeActive", "TearDown"]
times = [60000, 20000, 20000, 20000, 20000]
command = ["musher-exec", "motion.toml"]
cwd = "."
critical = true

[actuator.audio]
states = ["SetUp", "SelfCheck", "Active", "DeActive", "TearDown"]
times = [60000, 20000, 20000, 20000, 20000]
command = ["musher-exec", "audio.toml"]
cwd = "."
after = ["motion"]

[capability.walk]
description = "walk about"
actuators = ["motion"]
states = ["Active"]
`;
const ACTUATOR = name => `module = 6200
[state.Active]
shell = "echo ${name} is active"
[emergency_stop]
shell = "echo ${name} is stopped"
`;

// `config`: more lines for the state config.
export async function startRobot(config = '') {
  const folder = await mkdtemp(path.join(os.tmpdir(), 'musher-view-test-'));
  const robot = new Robot(folder);
  await writeFile(path.join(folder, 'dog.toml'), ROBOT.replace('NAMESPACE', robot.nameSpace) + config);
  for (const name of ['motion', 'audio']) await writeFile(path.join(folder, `${name}.toml`), ACTUATOR(name));
  try {
    await robot.up();
  } catch (error) {
    await robot.close();
    throw error;
  }
  return robot;
}

let robots = 0;

class Robot {
  constructor(folder) {
    this.folder = folder;
    this.nameSpace = `dog${process.pid}_${++robots}`;
    this.env = {...process.env, PATH: `${BIN}:${process.env.PATH}`, XDG_STATE_HOME: folder,
      ROS_DOMAIN_ID: String(215 + (process.pid % 18)), MUSHER_NAMESPACE: this.nameSpace};
    this.views = [];
  }

  get stateFolder() {
    return path.join(this.folder, 'musher', `dog@${this.nameSpace}.domain${this.env.ROS_DOMAIN_ID}`);
  }

  // What it prints. A failure of the program rejects; `code` is its exit code.
  async musher(...args) {
    const {stdout} = await promisify(execFile)(path.join(BIN, 'musher'), args, {env: this.env});
    return stdout;
  }

  up() {
    return this.musher('up', '--detach', path.join(this.folder, 'dog.toml'));
  }

  async status() {
    return JSON.parse(await this.musher('status', '--json'));
  }

  // musher-view beside the robot: {url, login, pin, token}.
  async view(...args) {
    const port = args.includes('--port') ? [] : ['--port', '0'];
    const child = spawn(path.join(BIN, 'musher-view'), [...port, ...args],
      {env: this.env, stdio: ['ignore', 'pipe', 'inherit']});
    this.views.push(child);
    const lines = createInterface({input: child.stdout})[Symbol.asyncIterator]();
    const url = /http:\S+\//.exec((await lines.next()).value)[0];
    const acting = (await lines.next()).value;
    const login = /http:\S+code=\w+/.exec(acting)[0];
    const pin = /PIN (\d{6})/.exec(acting)[1];
    const token = await readFile(path.join(this.folder, 'musher',
      `view_token@${this.nameSpace}.domain${this.env.ROS_DOMAIN_ID}`), 'utf8');
    return {child, url, login, pin, token: token.trim()};
  }

  async close() {
    for (const view of this.views) {
      view.kill('SIGTERM');
      if (view.exitCode === null && view.signalCode === null) await once(view, 'exit');
    }
    await this.musher('down').catch(() => {});
    await rm(this.folder, {recursive: true, force: true});
  }
}
