#pragma once

#include <dynamic_reconfigure/Config.h>
#include <ros/subscriber.h>

#include <QTimer>
#include <QWidget>
#include <functional>
#include <map>
#include <set>
#include <string>

class QBoxLayout;
class QCheckBox;
class QComboBox;
class QFormLayout;

namespace clothsim_rviz {

class CallQueue;

/// Sliders, boxes and a list for live values of a clothsim node: its material, with ks or the
/// stiffness of a fabric, its spring families and the shader of its pictures. They show the node's
/// values, also after changes by others.
class LiveControls : public QWidget {
 public:
  /// `report` shows refusals. The queue must outlive this.
  LiveControls(CallQueue&, std::function<void(const std::string&)> report);
  ~LiveControls() override;

  /// Takes the node's full name.
  void set_node(const std::string&);

 private:
  struct Server;  // of dynamic_reconfigure
  struct Number;

  static QFormLayout* add_form(QBoxLayout&);
  void add_number(QFormLayout&, const Number&);
  void add_fabric(QFormLayout&);
  void add_families(QFormLayout&);
  void add_shader(QFormLayout&);
  void change(const std::string& server, const std::function<void(dynamic_reconfigure::Config&)>&);
  void send();
  void send(const std::string& server, const dynamic_reconfigure::Config&);
  void hear(const std::string& server);
  void show_values(const std::string& server, const dynamic_reconfigure::Config&);
  void show_material(const dynamic_reconfigure::Config&);

  CallQueue& calls_;
  std::function<void(const std::string&)> report_;
  std::string node_;
  std::map<std::string, std::function<void(double)>> show_number_;  // by name
  std::map<std::string, QCheckBox*> families_;
  QFormLayout* springs_;             // for a cloth of springs: ks
  QFormLayout* fabric_;              // for a fabric
  std::set<std::string> of_fabric_;  // the names of the rows in fabric_
  QComboBox* shader_;
  std::map<std::string, dynamic_reconfigure::Config> changed_;  // by server, not sent yet
  QTimer send_timer_;
  std::map<std::string, ros::Subscriber> subscribers_;
};

}  // namespace clothsim_rviz
