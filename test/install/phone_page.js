// The page of a robot in a browser as on a phone: what a person must see there at once, and STOP, which is pressed.
//
//   node phone_page.js URL [--why TEXT] [--battery]
import {open, startBrowser} from '../view/page/browser.js';
import {PHONE, looksAt, stops} from '../view/page/phone.js';

const [url, ...options] = process.argv.slice(2);
const why = options.includes('--why') ? options[options.indexOf('--why') + 1] : null;

const browser = await startBrowser();
const {page, close} = await open(browser, {url, ...PHONE});
await looksAt(page, {why, battery: options.includes('--battery')});
const word = (await page.textContent('.big-state')).trim();
await stops(page);
await close();
await browser.close();
console.log(`phone_page: in ${PHONE.width} x ${PHONE.height} px: ${word}${why ? `; why: ${why}` : ''}; STOP was pressed`);
