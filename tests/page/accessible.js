// What holds of the page in each situation: axe-core finds nothing against WCAG 2.2 AA, and nothing is cut off at the
// right. DWELL_PICTURES=FOLDER keeps a picture of each.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const AXE = createRequire(import.meta.url).resolve('axe-core/axe.min.js');
const RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];

// page: opened with bypassCSP, because axe-core is injected as a script. The picture of a wall display shows its screen alone,
// any other the whole page.
export async function check(page, name) {
  if (process.env.DWELL_PICTURES)
    await page.screenshot({ path: join(process.env.DWELL_PICTURES, `${name}.png`), fullPage: !name.includes('wall') });
  await page.evaluate(await readFile(AXE, 'utf8'));
  const { violations } = await page.evaluate((rules) => window.axe.run(document, { runOnly: rules }), RULES);
  const found = violations.map((v) => `${v.id}: ${v.help}: ${v.nodes.map((n) => n.target.join(' ')).slice(0, 3).join(', ')}`);
  assert.deepEqual(found, [], name);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.ok(wide <= 0, `${name}: ${wide} px are cut off at the right`);
}
