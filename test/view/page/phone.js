// What a person must see of a robot on a phone at once, without scrolling: how it is, why it is broken, its battery, and
// STOP, one press of which stops it.
import assert from 'node:assert/strict';

export const PHONE = {width: 390, height: 844};

// The box of what is whole on the screen, with nothing in front of it.
function seen(page, selector) {
  return page.locator(selector).first().evaluate((node, what) => {
    const box = node.getBoundingClientRect();
    const fits = box.left >= 0 && box.top >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
    const front = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
    if (!fits || !node.contains(front)) throw new Error(`${what} is not seen: ${JSON.stringify(box)}`);
    return {top: box.top, width: box.width, height: box.height};
  }, selector);
}

const styleOf = (page, selector, name) => page.locator(selector).first()
  .evaluate((node, property) => getComputedStyle(node)[property], name);

// `why`: what is wrong, of the first problem. `battery`: it has one.
export async function looksAt(page, {why = null, battery = false} = {}) {
  await page.waitForSelector('.big-state .chip');
  await seen(page, '.big-state');
  assert.ok(parseFloat(await styleOf(page, '.big-state .chip', 'fontSize')) >= 24, 'the state is not a big word');
  if (why) {
    await page.waitForSelector(`.problem .reason >> text=${why}`);
    await seen(page, '.problem h3');
    await seen(page, '.problem .reason');
    assert.match(await page.textContent('.problem .advice'), /What to do: \w+/);
  }
  if (battery) {
    await page.waitForSelector('#top .battery');
    await seen(page, '#top .battery');
    assert.match(await page.textContent('#top .battery'), /\d+ ?%/);
  }
  const [scroll, inner] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(scroll <= inner, `the page is ${scroll} px wide in ${inner}`);
}

// One press of STOP, which is in the same place at the end of the page, too.
export async function stops(page) {
  const {top, width, height} = await seen(page, '.stop');
  assert.ok(width >= 44 && height >= 44, `STOP is ${width} x ${height} px: too small for a thumb`);
  await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
  assert.equal((await seen(page, '.stop')).top, top);
  await page.tap('.stop');
  await page.waitForSelector('.big-state .stopped:has-text("STOPPED")');
  await page.evaluate(() => scrollTo(0, 0));
  await seen(page, '.big-state .stopped');
  const colour = await styleOf(page, '.big-state .stopped', 'backgroundColor');
  const [red, green, blue] = colour.match(/\d+/g).map(Number);
  assert.ok(red > 2 * green && red > 2 * blue, `STOPPED is ${colour}, not red`);
}
