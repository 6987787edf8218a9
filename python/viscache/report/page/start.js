"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = new Map(data.settings.map(s => [s.id, s]));
const $ = id => document.getElementById(id);
const all = query => [...document.querySelectorAll(query)];
