// Pictures of the page of a running robot: node pictures.js URL FOLDER NAME VIEW...
// writes FOLDER/NAME-VIEW.png for each view (robot, timeline, ...). Exit code 1: the page has an error, or no
// robot on it within 15 s.
import path from 'node:path';
import {open, startBrowser} from './browser.js';

const [url, folder, name, ...views] = process.argv.slice(2);
if (views.length === 0) {
  console.error('usage: node pictures.js URL FOLDER NAME VIEW...');
  process.exit(2);
}
const browser = await startBrowser();
try {
  for (const view of views) {
    const {page, close} = await open(browser, {url, hash: view});
    await page.waitForLoadState('networkidle').catch(() => {});
    await page.screenshot({path: path.join(folder, `${name}-${view}.png`)});
    await close();
  }
} finally {
  await browser.close();
}
