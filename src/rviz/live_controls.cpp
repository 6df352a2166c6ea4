#include "live_controls.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QSlider>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "call_queue.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/render/shading.h"

namespace clothsim_rviz {
namespace {

// Servers of dynamic_reconfigure, below the node's name.
constexpr const char* of_cloth = "";
constexpr const char* of_looks = "/shading/cloth";

/// Least time between messages while a slider is dragged.
constexpr int send_period = 50;  // [ms]

constexpr int slider_steps = 1000;
constexpr double largest_number = 1e9;  // largest input; the node checks the limits
constexpr int width_of_numbers = 90;    // [pixel]

template <class List, class Value>
void put(List& list, const std::string& name, const Value& value) {
  const auto known =
      std::find_if(list.begin(), list.end(), [&](const auto& item) { return item.name == name; });
  if (known == list.end()) {
    list.emplace_back();
    list.back().name = name;
    list.back().value = value;
  } else {
    known->value = value;
  }
}

}  // namespace

/// The scale of a slider is logarithmic where `low` is above 0.
struct LiveControls::Number {
  const char* name;
  const char* label;
  double low, high;
  int decimals;
  double unit = 1;  // of the shown number, in that of the node

  double value(int step) const {
    const double t = double(step) / slider_steps;
    return low > 0 ? low * std::pow(high / low, t) : t * high;
  }
  int step(double value) const {
    const double inside = std::clamp(value, low, high);
    const double t = low > 0 ? std::log(inside / low) / std::log(high / low) : inside / high;
    return static_cast<int>(std::lround(slider_steps * t));
  }
};

LiveControls::LiveControls(CallQueue& calls, std::function<void(const std::string&)> report)
    : calls_(calls), report_(std::move(report)) {
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  springs_ = add_form(*all);
  add_number(*springs_, {"ks", "ks [N/m]", 1, 1e5, 1});
  fabric_ = add_form(*all);
  add_fabric(*fabric_);
  QFormLayout* form = add_form(*all);
  add_number(*form, {"density", "density [kg/m²]", 0.1, 15000, 2});
  add_number(*form, {"damping", "damping [1/s]", 0, 100, 2});
  add_families(*form);
  add_shader(*form);
  send_timer_.setSingleShot(true);
  connect(&send_timer_, &QTimer::timeout, this, [this] { send(); });
  setEnabled(false);
}

LiveControls::~LiveControls() = default;

QFormLayout* LiveControls::add_form(QBoxLayout& layout) {
  auto* part = new QWidget;
  auto* form = new QFormLayout(part);
  form->setContentsMargins(0, 0, 0, 0);
  layout.addWidget(part);
  return form;
}

void LiveControls::add_number(QFormLayout& form, const Number& number) {
  auto* slider = new QSlider(Qt::Horizontal);
  slider->setObjectName(number.name);
  slider->setRange(0, slider_steps);
  auto* box = new QDoubleSpinBox;
  box->setRange(0, largest_number);
  box->setDecimals(number.decimals);
  box->setKeyboardTracking(false);
  box->setFixedWidth(width_of_numbers);
  auto* row = new QHBoxLayout;
  row->addWidget(slider, 1);
  row->addWidget(box);
  form.addRow(number.label, row);

  const auto show = [number, slider, box](double of_node) {
    const double value = of_node / number.unit;
    const QSignalBlocker quiet_slider(slider), quiet_box(box);
    if (!slider->isSliderDown()) slider->setValue(number.step(value));
    box->setValue(value);
  };
  const std::string name = number.name;
  show_number_[name] = show;
  const auto set = [this, name, show, unit = number.unit](double shown) {
    show(shown * unit);
    change(of_cloth, [&](auto& config) { put(config.doubles, name, shown * unit); });
  };
  connect(slider, &QSlider::valueChanged, this,
          [number, set](int step) { set(number.value(step)); });
  connect(box, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, set);
}

void LiveControls::add_fabric(QFormLayout& form) {
  for (const Number& number :
       {Number{"stretch_stiffness_warp", "stretch warp [N/m]", 1, 1e4, 1},
        Number{"stretch_stiffness_weft", "stretch weft [N/m]", 1, 1e4, 1},
        Number{"shear_stiffness", "shear [N/m]", 0.1, 1e3, 2},
        Number{"bending_stiffness_warp", "bend warp [µN m]", 0.1, 1e3, 1, 1e-6},
        Number{"bending_stiffness_weft", "bend weft [µN m]", 0.1, 1e3, 1, 1e-6}}) {
    add_number(form, number);
    of_fabric_.insert(number.name);
  }
}

void LiveControls::add_families(QFormLayout& form) {
  auto* row = new QHBoxLayout;
  for (const std::string name : clothsim::spring_family_names) {
    auto* box = new QCheckBox(QString::fromStdString(name));
    row->addWidget(box);
    families_[name] = box;
    connect(box, &QCheckBox::toggled, this, [this, name](bool on) {
      change(of_cloth, [&](auto& config) { put(config.bools, name, on); });
    });
  }
  form.addRow("springs", row);
}

void LiveControls::add_shader(QFormLayout& form) {
  shader_ = new QComboBox;
  shader_->setToolTip("Of the cloth in the pictures of ~camera");
  for (const std::string& name : clothsim::shading_names()) {
    shader_->addItem(QString::fromStdString(name));
  }
  connect(shader_, QOverload<int>::of(&QComboBox::activated), this, [this] {
    change(of_looks,
           [&](auto& config) { put(config.strs, "shader", shader_->currentText().toStdString()); });
  });
  form.addRow("shader", shader_);
}

void LiveControls::set_node(const std::string& node) {
  node_ = node;
  changed_.clear();
  send_timer_.stop();
  subscribers_.clear();
  setEnabled(false);  // until the node's values are known
  for (const char* server : {of_cloth, of_looks}) hear(server);
}

void LiveControls::hear(const std::string& server) {
  subscribers_[server] = ros::NodeHandle().subscribe<dynamic_reconfigure::Config>(
      node_ + server + "/parameter_updates", 1,
      [this, server](const dynamic_reconfigure::Config::ConstPtr& config) {
        setEnabled(true);
        if (changed_.empty()) show_values(server, *config);
      });
}

void LiveControls::show_values(const std::string& server,
                               const dynamic_reconfigure::Config& config) {
  // Some names are in both: there is a ks of springs and one of light.
  if (server == of_cloth) {
    show_material(config);
    return;
  }
  for (const auto& text : config.strs) {
    if (text.name == "shader") shader_->setCurrentText(QString::fromStdString(text.value));
  }
}

void LiveControls::show_material(const dynamic_reconfigure::Config& config) {
  bool is_fabric = false;
  for (const auto& number : config.doubles) {
    const auto show = show_number_.find(number.name);
    if (show != show_number_.end()) show->second(number.value);
    is_fabric = is_fabric || (number.value > 0 && of_fabric_.count(number.name) > 0);
  }
  springs_->parentWidget()->setVisible(!is_fabric);
  fabric_->parentWidget()->setVisible(is_fabric);
  for (const auto& flag : config.bools) {
    const auto box = families_.find(flag.name);
    if (box == families_.end()) continue;
    const QSignalBlocker quiet(box->second);
    box->second->setChecked(flag.value != 0);
  }
}

void LiveControls::change(const std::string& server,
                          const std::function<void(dynamic_reconfigure::Config&)>& set) {
  set(changed_[server]);
  if (!send_timer_.isActive()) send_timer_.start(send_period);
}

void LiveControls::send() {
  for (const auto& [server, config] : changed_) send(server, config);
  changed_.clear();
}

void LiveControls::send(const std::string& server, const dynamic_reconfigure::Config& config) {
  const std::string name = node_ + server + "/set_parameters";
  calls_.post([this, server, name, config]() -> CallQueue::Answer {
    dynamic_reconfigure::Reconfigure service;
    service.request.config = config;
    if (!ros::service::call(name, service)) {
      return [this, name] { report_("no answer from " + name); };
    }
    // Refused values are reset.
    return [this, server, values = service.response.config] {
      report_("");
      if (changed_.empty()) show_values(server, values);
    };
  });
}

}  // namespace clothsim_rviz
