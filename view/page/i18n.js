// The language: the browser's, or the one chosen last. t(key, values) is its text.
import {TEXTS} from './texts.js';
import {VIEW_TEXTS} from './texts_views.js';

const ALL = {...TEXTS, ...VIEW_TEXTS};
const LANGUAGES = ['en', 'zh'];
const KEY = 'musher.language';

export function chooseLanguage(stored, preferred) {
  if (LANGUAGES.includes(stored)) return stored;
  for (const name of preferred ?? []) {
    const found = LANGUAGES.find(language => name.toLowerCase().startsWith(language));
    if (found) return found;
  }
  return 'en';
}

function stored() {
  try {
    return globalThis.localStorage?.getItem(KEY);
  } catch {
    return null;  // storage is switched off
  }
}

let current = chooseLanguage(stored(), globalThis.navigator?.languages);

export const language = () => current;
export const languageTag = () => (current === 'zh' ? 'zh-CN' : 'en');

export function setLanguage(name) {
  current = name;
  try {
    globalThis.localStorage?.setItem(KEY, name);
  } catch {
    // The choice counts until the page is closed.
  }
}

export const otherLanguage = () => (current === 'en' ? 'zh' : 'en');

export function has(key) {
  return key in ALL;
}

export function t(key, values = {}) {
  const text = ALL[key]?.[LANGUAGES.indexOf(current)] ?? key;
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

// For the test that both languages are complete.
export const allTexts = () => ALL;
